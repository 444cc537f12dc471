"""What the commands share: exit codes, counts, JSON, progress for a person who waits."""

import argparse
import contextlib
import dataclasses
import json
import math
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from enum import Enum

import numpy as np

OK, FAILED, BAD_INPUT, INTERRUPTED, TERMINATED = 0, 1, 2, 130, 143
EXIT_CODES = """exit codes:
  0    done
  1    the run failed, or a file could not be written
  2    bad arguments, or a model or scenario that is missing or not valid
  130  interrupted by Ctrl-C; the log so far is written where one was asked for
  143  ended by SIGTERM; the same"""


class Terminated(KeyboardInterrupt):
    """SIGTERM, as an exception that ends what goes on like Ctrl-C does."""


def code_of(error: BaseException | None) -> int:
    """The exit code of a command that this error has ended."""
    if isinstance(error, Terminated):
        return TERMINATED
    return INTERRUPTED if isinstance(error, KeyboardInterrupt) else FAILED


@contextlib.contextmanager
def sigterm_raises() -> Iterator[None]:
    """While a command runs SIGTERM raises `Terminated`, so that files are written and folders left."""

    def terminate(*_: object) -> None:
        raise Terminated("SIGTERM")

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def positive_count(text: str) -> int:
    """An integer of at least 1, for `add_argument`'s `type`."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, got {number}")
    return number


def progress(patience: float = 2.0) -> Callable[[float], None]:
    """Tell on standard error how much is done, and the time left, after `patience` seconds of waiting."""
    start = time.monotonic()
    shown = False

    def show(fraction: float) -> None:
        nonlocal shown
        if not sys.stderr.isatty():
            return
        if shown or time.monotonic() - start > patience:
            shown = True
            spent = time.monotonic() - start
            left = spent * (1.0 / fraction - 1.0) if fraction > 0.0 else 0.0
            text = f"\r{100 * fraction:3.0f} %, {left:.0f} s left   "
            end = "\n" if fraction >= 1.0 else ""
            print(text, end=end, file=sys.stderr, flush=True)

    return show


def print_json(data: object) -> None:
    """Print what a command found as JSON: dataclasses as objects, arrays as lists, NaN as null."""
    print(json.dumps(_plain(data), indent=2, ensure_ascii=False))


def _plain(data: object) -> object:
    if dataclasses.is_dataclass(data) and not isinstance(data, type):
        return {item.name: _plain(getattr(data, item.name)) for item in dataclasses.fields(data)}
    if isinstance(data, Mapping):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, np.ndarray | np.generic):
        return _plain(data.tolist())
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    if isinstance(data, Enum):
        return data.name.lower()
    if isinstance(data, float) and not math.isfinite(data):
        return None
    if data is None or isinstance(data, bool | int | float | str):
        return data
    return str(data)


def write_files(options: argparse.Namespace, writers: dict[str, Callable[[str], object]]) -> bool:
    """Write the files that were asked for, each even if another fails; True if all could be.

    Args:
        options: has a path, or None, under the name of each writer.
        writers: what writes to a path, by the option that names it.
    """
    good = True
    for name, write in writers.items():
        path = getattr(options, name)
        if path is None:
            continue
        try:
            write(path)
            print(f"wrote {path}", file=sys.stderr)
        except (OSError, ValueError, RuntimeError) as error:
            print(f"fikm-drake: cannot write {path}: {error}", file=sys.stderr)
            good = False
    return good
