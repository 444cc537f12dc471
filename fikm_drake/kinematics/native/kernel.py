"""Load the native kernel, if there is one for this machine."""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fikm_drake.arrays import Array
from fikm_drake.kinematics.native.build import LIBRARY, source_digest

INSTRUCTION_SETS = ("base", "avx2", "avx512")
VARIABLE = "FIKM_DRAKE_NATIVE"
"""Environment: 0 leaves the kernel out, an instruction set is the most that it may use."""
MOST_JOINTS = 64
"""Longer chains are left to numpy."""
_POINTER, _INT, _LONG = ctypes.c_void_p, ctypes.c_int, ctypes.c_int64
_DOUBLE = ctypes.c_double


class Kernel:
    """The functions of one library, for one instruction set.

    Arrays are passed as addresses: contiguous, of doubles, kept alive by the caller.

    Args:
        library: path of the library.
        most: the greatest instruction set to use.

    Raises:
        OSError: it cannot be loaded, is of other sources, or lacks a function.
    """

    def __init__(self, library: Path, most: str = INSTRUCTION_SETS[-1]) -> None:
        self.path = library
        loaded = ctypes.CDLL(str(library))
        try:
            carried = (ctypes.c_char * 16).in_dll(loaded, "fikm_source").value.decode()
            if carried != source_digest():
                raise OSError(
                    f"{library} is of other sources; python -m fikm_drake.kinematics.native.build"
                )
            best = min(loaded.fikm_processor(), INSTRUCTION_SETS.index(most))
            self.instruction_set = next(
                name
                for name in reversed(INSTRUCTION_SETS[: best + 1])
                if hasattr(loaded, f"fikm_solve_{name}")
            )
            self.kinematics = getattr(loaded, f"fikm_kinematics_{self.instruction_set}")
            self.solve = getattr(loaded, f"fikm_solve_{self.instruction_set}")
            self.step = loaded.fikm_step
            self.newton, self.arrive = loaded.fikm_newton, loaded.fikm_arrive
            self.stride = loaded.fikm_stride
            self.clear, self.clear_size = loaded.fikm_clear, loaded.fikm_clear_size
            self.task, self.cycle = loaded.fikm_task, loaded.fikm_cycle
            self.ask_clear, self.cycle_clear = loaded.fikm_ask_clear, loaded.fikm_cycle_clear
            self.cycle_size, self.step_at = loaded.fikm_cycle_size, loaded.fikm_step_at
            self.descend, self.error_sizes = loaded.fikm_descend, loaded.fikm_error_sizes
            self.gain, self.remember_turns = loaded.fikm_gain, loaded.fikm_remember_turns
            self.remember_motion = loaded.fikm_remember_motion
        except (AttributeError, ValueError, StopIteration) as error:
            raise OSError(f"{library} is no native kernel: {error}") from error
        self.kinematics.argtypes = [_POINTER, _INT, _LONG, _POINTER, _POINTER, _POINTER]
        self.kinematics.restype = None
        self.solve.argtypes = [_POINTER, _INT, _POINTER, _POINTER, _POINTER, _INT, _LONG]
        self.solve.argtypes += [_POINTER, _POINTER, _LONG, _POINTER, _POINTER]
        self.solve.restype = _INT
        self.clear.argtypes, self.clear.restype = [_POINTER, _INT], _INT
        self.clear_size.argtypes, self.clear_size.restype = [], _LONG
        self.step.argtypes = [_INT, _INT, _POINTER, _POINTER, *[_DOUBLE] * 7, _POINTER]
        self.step.restype = _INT
        curve: list[Any] = [_POINTER, _INT, _POINTER, _INT, _INT, *[_POINTER] * 4]
        self.newton.argtypes = [*curve, _POINTER, _POINTER, _DOUBLE, _POINTER]
        self.arrive.argtypes = [*curve, _POINTER]
        self.stride.argtypes = [*curve, _INT, _POINTER, _POINTER, _INT, _DOUBLE]
        self.stride.argtypes += [_POINTER] * 3
        self.task.argtypes, self.task.restype = [_POINTER, _INT, *[_POINTER] * 5], None
        self.gain.argtypes, self.gain.restype = [_POINTER, _POINTER, _DOUBLE], _DOUBLE
        self.remember_turns.argtypes, self.remember_turns.restype = [_POINTER] * 5, _INT
        self.remember_motion.argtypes, self.remember_motion.restype = [_POINTER] * 6, None
        self.step_at.argtypes = [*[_POINTER] * 4, _DOUBLE, _INT, _POINTER]
        self.step_at.restype = _INT
        self.descend.argtypes = [*[_POINTER] * 3, _INT, _POINTER]
        self.descend.restype = _INT
        self.error_sizes.argtypes = [_POINTER, _POINTER, _LONG, _POINTER, _POINTER]
        self.error_sizes.restype = None
        self.cycle_size.argtypes, self.cycle_size.restype = [], _LONG
        self.cycle.argtypes, self.cycle.restype = [*[_POINTER] * 7, _INT, _POINTER], _INT
        self.ask_clear.argtypes, self.ask_clear.restype = [_POINTER] * 9, _INT
        self.cycle_clear.argtypes = [*[_POINTER] * 8, _INT, _POINTER]
        self.cycle_clear.restype = _INT
        self.newton.restype = self.arrive.restype = self.stride.restype = _INT


def address(array: Array | NDArray[np.int64]) -> int:
    """Where a contiguous array of doubles, or of integers, lies."""
    return array.__array_interface__["data"][0]


def writable_address(array: Array) -> int:
    """The same for an array that can be written to, in a quarter of the time."""
    return _ADDRESS_OF(_CHARACTER.from_buffer(array))  # type: ignore[arg-type]


_ADDRESS_OF, _CHARACTER = ctypes.addressof, ctypes.c_char
_left_out = [False]


def kernel() -> Kernel | None:
    """The kernel, or None: numpy does the work."""
    return None if _left_out[0] else _load()[0]


@contextmanager
def numpy_only() -> Iterator[None]:
    """Leave the kernel out for a while, so that both can be compared in one process."""
    before, _left_out[0] = _left_out[0], True
    try:
        yield
    finally:
        _left_out[0] = before


def kernel_description() -> str:
    """One line for `fikm-drake --version`: which kernel works, and why."""
    loaded, why = _load()
    return f"native kernel ({loaded.instruction_set})" if loaded else f"numpy ({why})"


@cache
def _load() -> tuple[Kernel | None, str]:
    wanted = os.environ.get(VARIABLE, "")
    if wanted == "0":
        return None, f"{VARIABLE}=0"
    if not LIBRARY.is_file():
        return None, "no native kernel was built"
    try:
        most = wanted if wanted in INSTRUCTION_SETS else INSTRUCTION_SETS[-1]
        return Kernel(LIBRARY, most), ""
    except OSError as error:
        return None, str(error)
