"""Load the native kernel, if there is one for this machine."""

import ctypes
import os
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
        except (AttributeError, ValueError, StopIteration) as error:
            raise OSError(f"{library} is no native kernel: {error}") from error
        self.kinematics.argtypes = [_POINTER, _INT, _LONG, _POINTER, _POINTER, _POINTER]
        self.kinematics.restype = None
        self.solve.argtypes = [_POINTER, _INT, _POINTER, _POINTER, _POINTER, _INT, _LONG]
        self.solve.argtypes += [_POINTER, _POINTER, _LONG, _POINTER, _POINTER]
        self.solve.restype = _INT
        self.clear.argtypes, self.clear.restype = [_POINTER, _INT], _INT
        self.clear_size.argtypes, self.clear_size.restype = [], _LONG
        self.step.argtypes = [_INT, _INT, _POINTER, _POINTER, *[ctypes.c_double] * 5, _POINTER]
        self.step.restype = _INT
        curve: list[Any] = [_POINTER, _INT, _POINTER, _INT, _INT, *[_POINTER] * 4]
        self.newton.argtypes = [*curve, _POINTER, _POINTER, ctypes.c_double, _POINTER]
        self.arrive.argtypes = [*curve, _POINTER]
        self.stride.argtypes = [*curve, _INT, _POINTER, _POINTER, _INT, ctypes.c_double]
        self.stride.argtypes += [_POINTER] * 3
        self.newton.restype = self.arrive.restype = self.stride.restype = _INT


def address(array: Array | NDArray[np.int64]) -> int:
    """Where a contiguous array of doubles, or of integers, lies."""
    return array.__array_interface__["data"][0]


@cache
def kernel() -> Kernel | None:
    """The kernel, or None: numpy does the work."""
    return _load()[0]


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
