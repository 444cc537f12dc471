"""The generated C, compiled by the system's compiler where there is one."""

import re
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from fikm_drake.fuzzy.integer import IntegerRuleBase, write_c
from fikm_drake.fuzzy.integer.write_c import Shape

FLAGS = ("-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-Os")
SELF_TEST = "-DRULES_SELF_TEST"
DRIVER = """\
#include <stdio.h>
#include "rules.h"

int main(void)
{
    int32_t x, y, outputs[RULES_OUTPUTS];

    for (x = X_LOW; x <= X_HIGH; x += EVERY)
        for (y = Y_LOW; y <= Y_HIGH; y += EVERY) {
            rules_infer(x, y, outputs);
            fwrite(outputs, sizeof outputs, 1, stdout);
        }
    return 0;
}
"""
"""Writes what is inferred on a grid to standard output."""


def find_compiler() -> str | None:
    """Path of the system's C compiler; None: there is none."""
    return shutil.which("cc")


def find_valgrind() -> str | None:
    """Path of valgrind, which counts instructions; None: it is not installed."""
    return shutil.which("valgrind")


def passes_self_test(rules: IntegerRuleBase, shape: Shape) -> bool:
    """Whether the C compiles without a warning and its self-test returns 0."""
    with TemporaryDirectory() as folder:
        source, _ = write_c(rules, Path(folder) / "rules.c", shape=shape)
        program = Path(folder) / "self_test"
        compiled = _compile([source], program, SELF_TEST)
        return compiled and subprocess.run([program]).returncode == 0


def mismatches(rules: IntegerRuleBase, shape: Shape) -> int:
    """Integers that differ between C and Python at every input of the rules' range.

    Raises:
        RuntimeError: the C does not compile without a warning.
    """
    with TemporaryDirectory() as folder:
        done = subprocess.run([_driver(rules, shape, folder, every=1)], stdout=subprocess.PIPE)
    expected, _ = rules.infer_batch(*np.meshgrid(*_axes(rules, 1), indexing="ij"))
    ours: NDArray[np.int32] = np.frombuffer(done.stdout, np.int32)
    if ours.size != expected.size:
        return expected.size
    return int((ours != expected.ravel()).sum())


def instructions(rules: IntegerRuleBase, shape: Shape, *, every: int = 25) -> float:
    """Instructions of one call, the mean over every so many inputs, counted by valgrind.

    Raises:
        RuntimeError: the C does not compile, or valgrind does not run here.
    """
    with TemporaryDirectory() as folder:
        driver = _driver(rules, shape, folder, every=every)
        command = [str(find_valgrind()), "--tool=callgrind", "--toggle-collect=rules_infer"]
        command += [f"--callgrind-out-file={folder}/calls", str(driver)]
        report = subprocess.run(command, capture_output=True).stderr.decode("utf-8", "replace")
    found = re.search(r"Collected : (\d+)", report)
    if not found:
        raise RuntimeError(f"valgrind does not count here: {report}")
    x, y = _axes(rules, every)
    return int(found[1]) / (len(x) * len(y))


def _driver(rules: IntegerRuleBase, shape: Shape, folder: str, *, every: int) -> Path:
    source, _ = write_c(rules, Path(folder) / "rules.c", shape=shape)
    driver, program = Path(folder) / "driver.c", Path(folder) / "driver"
    driver.write_text(DRIVER, encoding="utf-8")
    limits = {"X_LOW": rules.first.low, "X_HIGH": rules.first.high}
    limits |= {"Y_LOW": rules.second.low, "Y_HIGH": rules.second.high, "EVERY": every}
    if not _compile([source, driver], program, *(f"-D{k}={v}" for k, v in limits.items())):
        raise RuntimeError("the generated C does not compile without a warning")
    return program


def _compile(sources: list[Path], program: Path, *defines: str) -> bool:
    command = [str(find_compiler()), *FLAGS, *defines, *map(str, sources), "-o", str(program)]
    done = subprocess.run(command, capture_output=True)
    return done.returncode == 0 and not done.stderr


def _axes(rules: IntegerRuleBase, every: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    first, second = rules.first, rules.second
    x = np.arange(first.low, first.high + 1, every)
    return x, np.arange(second.low, second.high + 1, every)
