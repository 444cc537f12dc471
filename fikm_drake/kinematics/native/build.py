"""Compile the native kernel: as hatchling's build hook, or `python -m fikm_drake.kinematics.native.build`.

This file imports nothing of the package, since hatchling runs it before there is one.
"""

import hashlib
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

FOLDER = Path(__file__).parent
LIBRARY = FOLDER / "_kernel.so"
"""Beside its sources, in a checkout too; git ignores it."""
SOURCES = (
    *(
        "lanes.h",
        "curve.h",
        "base.h",
        "clearance.h",
        "supervision.h",
        "task.h",
        "limits.h",
        "saturation.h",
        "retreat.h",
        "safe_step.h",
        "restart.h",
        "cycle.h",
    ),
    "kernel.c",
)
FLAGS = [
    "-std=c99",
    "-O3",
    "-fno-math-errno",
    "-ffp-contract=fast",
    "-fPIC",
    "-fvisibility=default",
]
X86 = {
    "avx2": ["-DW=4", "-mavx2", "-mfma"],
    "avx512": ["-DW=8", "-mavx512f", "-mavx512dq", "-mavx512vl", "-mfma", "-mavx2"],
}
"""What each instruction set is compiled with; the loader takes the best that the processor has."""
SECONDS = 300.0


def source_digest() -> str:
    """A digest of the sources and flags, which the library carries: an old one is known as such."""
    digest = hashlib.sha256(f"{platform.machine()} {FLAGS} {X86}".encode())
    for name in SOURCES:
        digest.update((FOLDER / name).read_bytes())
    return digest.hexdigest()[:16]


def build(library: Path = LIBRARY, *, flags: list[str] | None = None) -> str:
    """Compile the kernel.

    Args:
        library: the file to write, whole or not at all.
        flags: more flags for the compiler, such as those of a sanitizer.

    Returns:
        Empty, or why there is no library; then the file is as it was.
    """
    compiler = _compiler()
    if compiler is None:
        return "no C compiler found (CC, cc, gcc, clang)"
    machine = platform.machine().lower()
    x86 = machine in ("x86_64", "amd64")
    sets = {"base": [f"-DW={2 if x86 else 4}", f'-DSOURCE="{source_digest()}"']}
    sets |= X86 if x86 else {}
    with tempfile.TemporaryDirectory() as temporary:
        objects = []
        for name, options in sets.items():
            target = str(Path(temporary) / f"{name}.o")
            source = str(FOLDER / SOURCES[-1])
            command = [*compiler, *FLAGS, *(flags or []), *options, f"-DISA={name}"]
            problem = _run([*command, "-Wno-psabi", "-c", source, "-o", target])
            if not problem:
                objects.append(target)
            elif name == "base":
                return problem
        linked = Path(temporary) / library.name
        problem = _run([*compiler, *(flags or []), "-shared", *objects, "-lm", "-o", str(linked)])
        if problem:
            return problem
        beside = library.with_name(f"{library.name}.{os.getpid()}")
        try:
            shutil.copyfile(linked, beside)
            os.replace(beside, library)
        except OSError as error:
            beside.unlink(missing_ok=True)
            return f"cannot write {library}: {error}"
    return ""


def _compiler() -> list[str] | None:
    if os.environ.get("CC"):
        return os.environ["CC"].split()
    found = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
    return [found] if found else None


def _run(command: list[str]) -> str:
    """Run a compiler; empty, or what went wrong."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    except (OSError, subprocess.SubprocessError) as error:
        return str(error)
    return "" if done.returncode == 0 else done.stderr.strip() or f"{command[0]} failed"


# Only for hatchling, which loads this file by its path.
if not __name__.startswith("fikm_drake.") and importlib.util.find_spec("hatchling"):
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface

    class NativeKernelHook(BuildHookInterface):
        """Compiles the kernel into a wheel, or beside its sources for an editable install."""

        def initialize(self, version: str, build_data: dict) -> None:
            """Without a compiler the wheel is a pure one, in silence."""
            if os.environ.get("FIKM_DRAKE_NATIVE") == "0":
                return
            built = LIBRARY.is_file() and source_digest().encode() in LIBRARY.read_bytes()
            problem = "" if built else build()
            if problem:
                self.app.display_warning(f"no native kernel, numpy does the work: {problem}")
                return
            tag = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{tag}"
            build_data["artifacts"].append(LIBRARY.relative_to(self.root).as_posix())


if __name__ == "__main__":
    message = build()
    print(message or f"wrote {LIBRARY}")
    sys.exit(1 if message else 0)
