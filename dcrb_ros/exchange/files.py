"""Readers and writers for the file formats of other tools."""

from __future__ import annotations

import json
import math
import re
import struct
import warnings
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dcrb_ros.exchange.pieces import Show, pieces
from dcrb_ros.exchange.text_table import Array, numbered_column, read_table
from dcrb_ros.runtime.optional import installed
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.stream.axes import AXES
from dcrb_ros.text.files import check_regular, checked_path

MOST_RATIO = 256
"""Largest size of a file's channels in memory relative to the file [-]; a compressed waveform has 5."""
LEAST_LOADED = 64 * 1024 * 1024
"""Size up to which the channels of any file are loaded [bytes]."""
MAT_BYTES = {"int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "single": 4, "char": 2, "logical": 1}
"""Size of an element by its class in a MAT file [bytes], where it is not 8."""

MAT_NUMBERS = {name.encode() for name in MAT_BYTES if name != "char"} | {b"double", b"int64", b"uint64"}
"""Classes of a MAT file whose elements are numbers."""
OBJECTS = "Object arrays cannot be loaded"
"""Beginning of what numpy says of an array of pickled objects."""
WAVE_FORMS = (b"RIFF", b"RIFX", b"RF64")
"""Beginnings of WAV files: little and big endian, and that with sizes of 64 bits."""
MAT_HEADER, MAT_COMPRESSED, MAT_PIECE = 128, 15, 1 << 20
"""Size of the header of a MAT file [bytes], type of a compressed variable, and size of a part that is unpacked at a time [bytes]."""
LARGEST_MAT_ARRAY = 2**32 - 1024
"""Largest array in a MAT file of version 5 [bytes]: with its name, it has a size of 32 bits."""
LARGEST_WAV = 2**32 - 1024
"""Most bytes of samples in a WAV file: with its header, it has a size of 32 bits."""
LARGEST_ELEMENT = 8
"""Size in memory of a number that a MAT file stores in one byte [bytes]."""


@dataclass(frozen=True)
class ExternalFile:
    """The channels of a file by name or number, and the sampling rate if the file contains it."""

    names: tuple[str, ...]
    column: Callable[[str | int], Array]
    """Return a channel; raises KeyError, IndexError or AttributeError if there is no such channel."""
    rate: int | None = None
    """Sampling rate [Hz]."""
    full_scale: float | None = None
    """Number that corresponds to full scale in a file with integer samples [-]."""


def read_external(path: Path) -> ExternalFile:
    """Return the channels of a file, whose format is given by its suffix.

    Raises:
        Refusal: the suffix is unknown, or the file does not exist or has another format.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise Refusal(f"{path} has an unknown file type: its name must end in one of {', '.join(READERS)}")
    if not checked_path(path).exists():
        raise Refusal(f"there is no file {path}: check the path")
    check_regular(path)
    with _explained(path):
        return reader(path)


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    """Refuse a file in whose content a library finds a mistake."""
    try:
        yield
    except Refusal:
        raise
    except Exception as error:  # the libraries raise many kinds of exceptions for invalid files
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise Refusal(f"{path} cannot be read as {path.suffix[1:].upper()}: {reason}") from None


def _read_on_demand(path: Path, names: Sequence[str], read: Callable[[str], Array]) -> ExternalFile:
    """Return a file of which a channel is read, by its name, only when it is asked for."""

    def column(name: str | int) -> Array:
        if str(name) not in names:
            raise KeyError(name)
        with _explained(path):
            return read(str(name))

    return ExternalFile(tuple(names), column)


def _check_loaded(path: Path, size: int) -> None:
    """Refuse a small file that states channels of ``size`` [bytes]."""
    most = max(LEAST_LOADED, MOST_RATIO * path.stat().st_size)
    if size > most:
        raise Refusal(f"{path} has {path.stat().st_size} bytes, but its channels have {size}; at most {most} are loaded: split it")


def channel(external: ExternalFile, source: Path, name: str | int) -> Array:
    """Return one channel of a file as an array of shape (samples,).

    Raises:
        Refusal: there is no such channel, or it is not a one-dimensional array of numbers.
    """
    try:
        array = np.asarray(external.column(name))
    except Refusal:
        raise
    except (KeyError, IndexError, AttributeError, ValueError, TypeError):
        known = ", ".join(external.names[:20]) or "none"
        raise Refusal(f"{source} has no channel '{name}'{nearest(str(name), external.names)} (available: {known})") from None
    values = np.atleast_1d(array.squeeze())
    if values.ndim != 1 or values.dtype.kind not in "iuf":
        raise Refusal(f"{source}: '{name}' has shape {array.shape} and type {array.dtype}: a channel must be one row of numbers")
    return values


def _read_npz(path: Path) -> ExternalFile:
    with zipfile.ZipFile(path) as packed:
        _check_loaded(path, sum(entry.file_size for entry in packed.infolist()))
    with np.load(path, allow_pickle=False) as file:
        return _read_on_demand(path, file.files, lambda name: _from_npz(path, name))


def _from_npz(path: Path, name: str) -> Array:
    """Return an array of an NPZ file; an array of objects, which only unpickling would load, is empty."""
    try:
        with np.load(path, allow_pickle=False) as file:
            return np.asarray(file[name])
    except ValueError as error:
        if OBJECTS not in str(error):
            raise
        return np.empty(0, object)


def _read_wav(path: Path) -> ExternalFile:
    from scipy.io import wavfile

    _check_chunks(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)  # of chunks that contain no samples
        rate, table = wavfile.read(path)
    table = table[:, None] if table.ndim == 1 else table
    kind = table.dtype
    if kind.kind == "u":
        raise Refusal(f"{path} has {8 * kind.itemsize} bit unsigned samples: convert it to 16 bit or to floating point")
    scale = float(np.iinfo(kind).max) + 1.0 if kind.kind == "i" else None
    return ExternalFile(tuple(str(k + 1) for k in range(table.shape[1])), lambda name: numbered_column(table, name), int(rate), scale)


def _check_chunks(path: Path) -> None:
    """Refuse a file that is no WAV file, one without samples, and one whose chunks state more bytes than follow, or none."""
    with path.open("rb") as file:
        form = file.read(12)
        if form[:4] not in WAVE_FORMS or form[8:] != b"WAVE":
            raise Refusal(f"{path} is not a WAV file: it begins with {form!r}, not with RIFF, a size and WAVE; give it its own suffix")
        order = ">" if form[:4] == b"RIFX" else "<"
        sizes = {b"RIFF": struct.unpack(f"{order}4xI4x", form)[0]}
        while len(head := file.read(8)) == 8:
            name, size = head[:4], struct.unpack(f"{order}4xI", head)[0]
            left = path.stat().st_size - file.tell()
            if name == b"ds64" and left >= 16:  # the sizes of the file and of its samples
                sizes[b"RIFF"], sizes[b"data"] = struct.unpack("<QQ", file.read(16))
                file.seek(-16, 1)
            sizes[name] = size = sizes[name] if name == b"data" and b"ds64" in sizes else size
            # A recorder writes the sizes last; without that of the file, scipy reads nothing.
            stated = b"RIFF" if not sizes[b"RIFF"] else name if size > left or (name == b"data" and left and not size) else b""
            if stated:
                raise Refusal(
                    f"{path} is cut off: its chunk {stated!r} states {sizes[stated]} bytes, but {left} follow; copy the file again, or, if "
                    "its recording never finished, repair its header with an audio program"
                )
            file.seek(size + size % 2, 1)
        if missing := [name.decode() for name in (b"fmt ", b"data") if name not in sizes]:
            raise Refusal(f"{path} has no chunk {' and no chunk '.join(missing)}: copy the file again")


def _read_mat(path: Path) -> ExternalFile:
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import matfile_version

    try:
        _check_loaded(path, sum(math.prod(shape) * MAT_BYTES.get(kind, 8) for _, shape, kind in whosmat(path)))
        if matfile_version(path)[0] == 1:
            _check_loaded(path, LARGEST_ELEMENT * _unpacked_mat(path))
        variables = loadmat(path, squeeze_me=True, struct_as_record=False)
    except NotImplementedError:  # so scipy answers files of version 7.3, which are HDF5
        return _read_hdf5(path)
    names = _field_names({name: value for name, value in variables.items() if not name.startswith("__")})
    return ExternalFile(tuple(names), lambda name: _nested(variables, str(name)))


def _field_names(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield the names of variables, and of a structure those of its fields, such as ``bearing.gs``."""
    for name, value in values.items():
        fields = {f"{name}.{field}": getattr(value, field) for field in getattr(value, "_fieldnames", ())}
        yield from _field_names(fields) if fields else [name]


def _unpacked_mat(path: Path) -> int:
    """Return the size of the variables of a MAT file of version 5 without their compression [bytes], counted without keeping them.

    `whosmat` gives the shape of a structure, but not the size of its fields. The count ends beyond the largest size that is loaded.
    """
    most = max(LEAST_LOADED, MOST_RATIO * path.stat().st_size)
    total = 0
    with path.open("rb") as file:
        order = "<" if file.read(MAT_HEADER)[-2:] == b"IM" else ">"
        while len(tag := file.read(8)) == 8 and total <= most:
            kind, size = struct.unpack(f"{order}II", tag)
            if kind != MAT_COMPRESSED:
                total += size
                file.seek(size, 1)
                continue
            packed, unpacked = file.read(size), zlib.decompressobj()
            while packed and not unpacked.eof and total <= most:
                total += len(unpacked.decompress(packed, MAT_PIECE))
                packed = unpacked.unconsumed_tail
    return total


def _nested(variables: Mapping[str, Any], name: str) -> Array:
    """Return a variable, or a field of a structure, such as ``bearing.gs`` or ``run.Y[7].Data``."""
    if name in variables:
        return np.asarray(variables[name])
    head, *parts = re.findall(r"[^.\[\]]+", name)
    value = variables[head]
    for part in parts:
        if part == "0":
            raise IndexError(name)
        value = np.atleast_1d(value)[int(part) - 1] if part.isdigit() else getattr(value, part)
    return np.asarray(value)


def _read_hdf5(path: Path) -> ExternalFile:
    h5py = installed("h5py", f"{path} is a MAT file of version 7.3, which needs h5py: pip install h5py, or save it with -v7")
    places: dict[str, str] = {}
    with h5py.File(path, "r") as file:

        def keep(place: str, entry: Any) -> None:
            numeric = isinstance(entry, h5py.Dataset) and entry.dtype.kind in "iuf"
            # MATLAB stores characters and references to its objects as integers, too.
            if numeric and not place.startswith("#") and entry.attrs.get("MATLAB_class", b"double") in MAT_NUMBERS:
                places[place.replace("/", ".")] = place

        file.visititems(keep)
        _check_loaded(path, sum(file[place].nbytes for place in places.values()))

    def read(name: str) -> Array:
        with h5py.File(path, "r") as file:
            entry = file[places[name]]
            return np.asarray(entry[()] if not entry.attrs.get("MATLAB_empty") else ())  # which has its shape as content

    return _read_on_demand(path, list(places), read)


def _read_parquet(path: Path) -> ExternalFile:
    import pyarrow
    from pyarrow import parquet

    about, schema = parquet.read_metadata(path), parquet.read_schema(path)
    stamps = {field.name for field in schema if pyarrow.types.is_timestamp(field.type)}
    # A list or a text can be any times as large as the file, and is no channel.
    numeric = pyarrow.types.is_integer, pyarrow.types.is_floating, pyarrow.types.is_timestamp
    names = [field.name for field in schema if any(kind(field.type) for kind in numeric)]
    if stamps.issuperset(names):
        raise Refusal(f"{path} has no column of numbers, but {', '.join(map(str, schema.types[:5]))}: write one number in each row")
    _check_loaded(path, 8 * about.num_rows * len(names))

    def read(name: str) -> Array:
        values = np.asarray(parquet.read_table(path, columns=[name]).column(name).to_numpy())
        # From the first row on, since a date in seconds has less than a microsecond of precision.
        return (values - values[:1]) / np.timedelta64(1, "s") if name in stamps else values

    return _read_on_demand(path, names, read)


READERS: dict[str, Callable[[Path], ExternalFile]] = {
    ".csv": lambda path: ExternalFile(*read_table(path)),
    ".wav": _read_wav,
    ".mat": _read_mat,
    ".npz": _read_npz,
    ".parquet": _read_parquet,
}

Columns = Mapping[str, Array]
WRITING = "writing"
"""Stage of the progress."""


def _write_npz(path: Path, columns: Columns, extra: Columns, rate: float, about: Mapping[str, Any], show: Show) -> None:
    arrays: dict[str, Any] = {**columns, **extra, "sampling_rate": np.array(rate), "about": np.array(json.dumps(about))}
    with path.open("wb") as stream:
        np.savez(stream, **arrays)


def _write_csv(path: Path, columns: Columns, extra: Columns, rate: float, about: Mapping[str, Any], show: Show) -> None:
    # Nine digits represent a float32 exactly, 17 a float64; a time is given to the nanosecond.
    digits = {name: 17 if values.dtype == np.float64 else 9 for name, values in columns.items()}
    forms = ["%d" if values.dtype.kind == "i" else "%.9f" if name == "time" else f"%.{digits[name]}g" for name, values in columns.items()]
    with path.open("w", encoding="utf-8") as stream:  # a pipe can be opened once; numpy opens a path twice
        stream.write(f"{','.join(columns)}\n")
        for piece in pieces(len(columns["index"]), show, WRITING):
            np.savetxt(stream, np.column_stack([values[piece].astype(np.float64) for values in columns.values()]), forms, delimiter=",")


def _write_mat(path: Path, columns: Columns, extra: Columns, rate: float, about: Mapping[str, Any], show: Show) -> None:
    from scipy.io import savemat

    arrays = {**columns, **extra}
    name = max(arrays, key=lambda name: arrays[name].nbytes)
    if arrays[name].nbytes > LARGEST_MAT_ARRAY:
        raise Refusal(f"a MAT file cannot represent 4 GiB of '{name}', {len(arrays[name])} numbers: export it as npz or parquet")
    savemat(path, {**arrays, "sampling_rate": rate, "about": json.dumps(about)}, do_compression=True, oned_as="column")


def _write_wav(path: Path, columns: Columns, extra: Columns, rate: float, about: Mapping[str, Any], show: Show) -> None:
    from scipy.io import wavfile

    steps = np.diff(columns["index"])
    if np.any(steps != 1):
        raise Refusal(
            f"a WAV file cannot represent gaps, of which the recording has {int(np.sum(steps != 1))}: export it as npz, mat, csv or parquet"
        )
    channels = [columns[name] for name in (*AXES, "shaft_angle") if name in columns]
    size = np.result_type(*channels).itemsize * sum(map(len, channels))
    if size > LARGEST_WAV:
        raise Refusal(f"a WAV file cannot represent {size} bytes of samples, at most {LARGEST_WAV}: export it as npz or parquet")
    wavfile.write(path, round(rate), np.column_stack(channels))


def _write_parquet(path: Path, columns: Columns, extra: Columns, rate: float, about: Mapping[str, Any], show: Show) -> None:
    import pyarrow
    from pyarrow import parquet

    about_file = {"dcrb_ros": json.dumps(about), "sampling_rate": str(rate)}
    schema = pyarrow.schema([(name, pyarrow.from_numpy_dtype(values.dtype)) for name, values in columns.items()], about_file)
    with path.open("wb") as stream, parquet.ParquetWriter(stream, schema) as writer:  # pyarrow itself cannot write to a pipe
        for piece in pieces(len(columns["index"]), show, WRITING):
            writer.write_table(pyarrow.table({name: values[piece] for name, values in columns.items()}, schema))


WRITERS: dict[str, Callable[[Path, Columns, Columns, float, Mapping[str, Any], Show], None]] = {
    ".csv": _write_csv,
    ".wav": _write_wav,
    ".mat": _write_mat,
    ".npz": _write_npz,
    ".parquet": _write_parquet,
}
