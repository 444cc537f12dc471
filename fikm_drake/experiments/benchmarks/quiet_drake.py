"""Drake's differential IK without its chatter on the terminal."""

import ctypes
import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet_drake() -> Iterator[None]:
    """Without Drake's warnings of a stuck or failed solver and without OSQP's own lines.

    OSQP writes a line to the standard output of the process for every problem without an active
    constraint, beside Python's `sys.stdout`.
    """
    logger = logging.getLogger("drake")
    level = logger.level
    logger.setLevel(logging.ERROR)
    sys.stdout.flush()
    terminal, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        ctypes.CDLL(None).fflush(None)  # what C has buffered belongs nowhere too
        os.dup2(terminal, 1)
        os.close(terminal)
        os.close(nowhere)
        logger.setLevel(level)
