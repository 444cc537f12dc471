"""Keep numpy's OpenBLAS to one thread for a while.

Products and factors of matrices of some hundred rows wake its threads, which then wait for each other:
on two busy cores a factor of 2 ms takes 20 to 2000. numpy offers no switch; its wheels bring their own
OpenBLAS, which has one. Another BLAS is left as it is.
"""

import contextlib
import ctypes
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from threading import Lock

import numpy as np

_NAMES = ("scipy_openblas_{}_num_threads64_", "scipy_openblas_{}_num_threads")
_lock, _inside, _before = Lock(), 0, 1


@contextlib.contextmanager
def one_blas_thread() -> Iterator[None]:
    """Within the block numpy's linear algebra runs in the thread that calls it, in all threads."""
    global _inside, _before
    switch = _switch()
    if switch is None:
        yield
        return
    get, put = switch
    with _lock:
        if not _inside:
            _before = get()
            put(1)
        _inside += 1
    try:
        yield
    finally:
        with _lock:
            _inside -= 1
            if not _inside:
                put(_before)


@cache
def _switch() -> tuple[Callable[[], int], Callable[[int], None]] | None:
    """OpenBLAS's functions that get and set the number of threads."""
    package = Path(np.__file__).parent
    for folder in (package.parent / "numpy.libs", package / ".dylibs"):
        for path in sorted(folder.glob("*openblas*")):
            try:
                library = ctypes.CDLL(str(path))
            except OSError:
                continue
            for name in _NAMES:
                with contextlib.suppress(AttributeError):
                    get, put = (getattr(library, name.format(verb)) for verb in ("get", "set"))
                    put.restype, put.argtypes = None, [ctypes.c_int]
                    return get, put
    return None
