"""What the commands share: exit codes, counts, progress for a person who waits."""

import argparse
import sys
import time
from collections.abc import Callable

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
EXIT_CODES = """exit codes:
  0    done
  1    the run failed, or a file could not be written
  2    bad arguments, or a model or scenario that is missing or not valid
  130  interrupted; the log so far is written where one was asked for"""


def positive_count(text: str) -> int:
    """An integer of at least 1, for `add_argument`'s `type`."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, got {number}")
    return number


def progress(patience: float = 2.0) -> Callable[[float], None]:
    """A progress line on standard error, for a person who has waited for `patience` seconds."""
    start = time.monotonic()
    shown = False

    def show(fraction: float) -> None:
        nonlocal shown
        if not sys.stderr.isatty():
            return
        if shown or time.monotonic() - start > patience:
            shown = True
            end = "\n" if fraction >= 1.0 else ""
            print(f"\r{100 * fraction:3.0f} %", end=end, file=sys.stderr, flush=True)

    return show
