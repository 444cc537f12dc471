"""Logs on disk: a .npz archive when the run is over, and until then a file that grows with it.

Both hold the same: a head (`LogInfo`) and float64 series. Nothing is compressed, so a log takes no
more memory than its file has bytes, however the file came to be; nothing is unpickled.

The growing file: a line that says what it is, the head with its length, then blocks of rows, each with
its length and checksum. Where the process ends between two blocks, or in one, all whole blocks are there.
"""

import io
import os
import struct
import time
import zipfile
import zlib
from pathlib import Path
from typing import BinaryIO

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.files import whole_file
from fikm_drake.simulation.log_info import LogInfo

MAGIC = b"fikm_drake growing log 2\n"
HEAD = struct.Struct("<II")
"""Before the head and each block: its bytes or rows, its checksum."""
BETWEEN_FLUSHES = 0.5
"""Rows are at most this old when they reach the file, while others come [s]."""
MOST_SERIES = 2000


def write_archive(path: str | Path, info: LogInfo, table: Array) -> None:
    """Write a log as .npz: `time`, each series as (N, columns), and `info.json`.

    Args:
        path: of the file.
        info: the head.
        table: time and all columns (N, 1 + width), in the order of `info.columns`.

    Raises:
        OSError: the file cannot be written.
    """
    with whole_file(path) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        archive.writestr("info.json", info.to_json())
        _write_array(archive, "time", table[:, 0])
        start = 1
        for name, labels in info.columns.items():
            _write_array(archive, name, table[:, start : start + len(labels)])
            start += len(labels)


def read_log(path: str | Path) -> tuple[LogInfo, Array]:
    """Head and table (N, 1 + width) of a log, whole or still growing.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it is no log, or damaged; the message names the file.
    """
    if not Path(path).exists():
        raise FileNotFoundError(f"no log {path}")
    try:
        with open(path, "rb") as file:
            growing = file.read(len(MAGIC)) == MAGIC
            info, table = (_read_growing if growing else _read_archive)(file)
        times = table[:, 0]
        if not len(times) or not np.isfinite(times).all() or not (np.diff(times) > 0).all():
            raise ValueError("its times are not finite and increasing, or there is none")
        return info, table
    except OSError as error:
        raise ValueError(f"{path} is not a log of fikm_drake: {error}") from error
    except (ValueError, KeyError, EOFError, RuntimeError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path} is not a log of fikm_drake, or damaged: {error}") from error
    except Exception as error:  # a damaged archive can raise more from zipfile and struct
        raise ValueError(f"{path} is damaged: {error}") from error


class GrowingLog:
    """A file that takes the rows of a run as they come, and can be read at any moment.

    Nothing is written before `BETWEEN_FLUSHES` have passed: a short run leaves an old file at `path` as it
    is until it is over and saved. Where the disk is full, `failed` says so and the run goes on.

    Args:
        path: of the file.
        info: the head.
    """

    def __init__(self, path: str | Path, info: LogInfo) -> None:
        self._path, self._info = Path(path), info
        self._file: BinaryIO | None = None
        self._rows: list[Array] = []
        self._flushed = time.monotonic()
        self.failed: OSError | None = None

    def append(self, row: Array) -> None:
        """Take a row (1 + width,), time first."""
        self._rows.append(row)
        if time.monotonic() - self._flushed > BETWEEN_FLUSHES:
            self.flush()

    def flush(self) -> None:
        """Write the rows that came since the last time."""
        self._flushed = time.monotonic()
        rows, self._rows = self._rows, []
        if self.failed is not None or not rows:
            return
        payload = np.asarray(rows, dtype="<f8").tobytes()
        block = HEAD.pack(len(rows), zlib.crc32(payload)) + payload
        try:
            if self._file is None:
                head = self._info.to_json()
                with whole_file(self._path) as file:
                    file.write(MAGIC + HEAD.pack(len(head), zlib.crc32(head)) + head + block)
                self._file = open(self._path, "ab", buffering=0)
            else:
                self._file.write(block)
        except OSError as error:
            self.failed = error

    def close(self) -> None:
        """Write what is left and let go of the file."""
        if self._file is not None:
            self.flush()
            self._file.close()
            self._file = None


def _write_array(archive: zipfile.ZipFile, name: str, values: Array) -> None:
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, np.ascontiguousarray(values, dtype="<f8"))
    archive.writestr(f"{name}.npy", buffer.getvalue())


def _read_archive(file: BinaryIO) -> tuple[LogInfo, Array]:
    size = os.fstat(file.fileno()).st_size
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
        stored = all(m.compress_type == zipfile.ZIP_STORED for m in members)
        if not stored or sum(m.file_size for m in members) > size or len(members) > MOST_SERIES:
            raise ValueError("its members are compressed, overlap or are too many")
        info = LogInfo.from_json(archive.read("info.json"))
        expected = {"info.json", "time.npy", *(f"{name}.npy" for name in info.columns)}
        if odd := sorted(expected ^ {m.filename for m in members})[:3]:
            raise ValueError(f"members that are missing or unknown: {', '.join(odd)}")
        times = _array(archive.read("time.npy"), "time", None)
        columns = [times[:, None]]
        for name, labels in info.columns.items():
            columns.append(_array(archive.read(f"{name}.npy"), name, (len(times), len(labels))))
    return info, np.concatenate(columns, axis=1)


def _array(data: bytes, name: str, expected: tuple[int, int] | None) -> Array:
    """A float64 array of that shape, or of one axis; nothing larger than `data` is made."""
    stream = io.BytesIO(data)
    if np.lib.format.read_magic(stream) != (1, 0):
        raise ValueError(f"{name} is not a plain array")
    shape, fortran, dtype = np.lib.format.read_array_header_1_0(stream)
    if shape != (expected or (shape[0] if shape else 0,)) or fortran or dtype != np.dtype("<f8"):
        raise ValueError(
            f"{name} is {dtype} of shape {shape}, expected float64 {expected or '(N,)'}"
        )
    if len(data) - stream.tell() != 8 * int(np.prod(shape)):
        raise ValueError(f"{name} has {len(data) - stream.tell()} bytes for the shape {shape}")
    return np.frombuffer(data, dtype="<f8", offset=stream.tell()).reshape(shape)


def _read_growing(file: BinaryIO) -> tuple[LogInfo, Array]:
    data = file.read()
    at = 0

    def take(size_of_unit: int) -> bytes | None:
        """The next block whose length counts units of so many bytes; None: the file ends in it."""
        nonlocal at
        if at + HEAD.size > len(data):
            return None
        count, checksum = HEAD.unpack_from(data, at)
        end = at + HEAD.size + count * size_of_unit
        if end > len(data):
            return None
        block = data[at + HEAD.size : end]
        if zlib.crc32(block) != checksum:
            if end == len(data):
                return None
            raise ValueError(f"the block at byte {at} is damaged")
        at = end
        return block

    head = take(1)
    if head is None:
        raise ValueError("it ends in its head")
    info = LogInfo.from_json(head)
    width = 1 + info.width
    blocks = []
    while (block := take(8 * width)) is not None:
        blocks.append(np.frombuffer(block, dtype="<f8").reshape(-1, width))
    info.ended = info.ended or "the process ended before it could close the log"
    return info, np.concatenate(blocks) if blocks else np.empty((0, width))
