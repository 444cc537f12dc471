"""Files are written whole or not at all: every saver of the library goes through here."""

import contextlib
import csv
import io
import os
import stat
import tempfile
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, BinaryIO

if TYPE_CHECKING:  # loading matplotlib takes as long as all of pydrake
    from matplotlib.figure import Figure


@contextlib.contextmanager
def whole_file(path: str | Path) -> Iterator[BinaryIO]:
    r"""A binary file to write in, which takes the place of `path` once it is whole and on the disk.

        with whole_file("run.csv") as file:
            file.write(b"time_s,gain\n")

    The bytes go to a hidden file beside it. Where the writing fails (a full disk, an exception in the
    block, a killed process) whatever was at `path` stays as it was; a link stays a link, and the file's
    mode is kept. What is no ordinary file, such as /dev/stdout or a pipe, is written as it comes.

    Args:
        path: of the file; its folder must exist.

    Raises:
        OSError: it cannot be written; the error names `path`.
    """
    target = Path(os.path.realpath(path))
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        mode = None
    if mode is not None and not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        with open(target, "wb") as file:
            yield file
        return
    part = None
    try:
        if mode is not None and stat.S_ISDIR(mode):
            raise IsADirectoryError(21, "is a folder", str(path))
        handle, part = tempfile.mkstemp(
            prefix=f".{target.name}.", suffix=".part", dir=target.parent
        )
        with open(handle, "wb") as file:
            os.fchmod(handle, 0o666 & ~_umask() if mode is None else stat.S_IMODE(mode))
            yield file
            file.flush()
            os.fsync(handle)
        os.replace(part, target)
        part = None
    except OSError as error:
        raise type(error)(error.errno, error.strerror or str(error), str(path)) from error
    finally:
        if part is not None:
            with contextlib.suppress(OSError):
                os.unlink(part)


def write_whole(path: str | Path, data: str | bytes) -> None:
    """Write a text (as UTF-8) or bytes to `path`, whole or not at all; see `whole_file`.

    Raises:
        OSError: it cannot be written; the error names `path`.
    """
    with whole_file(path) as file:
        file.write(data.encode("utf-8") if isinstance(data, str) else data)


def write_csv(path: str | Path, rows: Iterable[Iterable[object]]) -> None:
    """Write a CSV file row by row, whole or not at all; see `whole_file`.

    Raises:
        OSError: it cannot be written; the error names `path`.
    """
    with whole_file(path) as file:
        text = io.TextIOWrapper(file, encoding="utf-8", newline="")
        csv.writer(text).writerows(rows)
        text.flush()
        text.detach()


def _umask() -> int:
    """The mode bits that new files do not get; Python has no way to read them but to set them."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask


def new_figure(width: float, height: float) -> "Figure":
    """An empty matplotlib figure [inches]; pyplot is not touched, so nothing has to be closed."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: "Figure", path: str | Path, *, dpi: int = 120) -> None:
    """Write a matplotlib figure to `path`, whole or not at all; see `whole_file`.

    Raises:
        OSError: the file cannot be written.
        ValueError: matplotlib does not know the file's type.
    """
    kind = Path(path).suffix.removeprefix(".") or "png"
    if kind not in figure.canvas.get_supported_filetypes():
        known = ", ".join(sorted(figure.canvas.get_supported_filetypes()))
        raise ValueError(f"no picture can be written as .{kind} ({path}); there are: {known}")
    with whole_file(path) as file:
        figure.savefig(file, dpi=dpi, format=kind)


def import_pandas() -> ModuleType:
    """pandas, which is no dependency.

    Raises:
        ImportError: it is not installed.
    """
    try:
        return import_module("pandas")
    except ImportError as error:
        raise ImportError("to_dataframe needs pandas: pip install pandas") from error
