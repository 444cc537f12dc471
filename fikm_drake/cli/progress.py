"""Progress for a person who waits."""

import sys
import time
from collections.abc import Callable


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
