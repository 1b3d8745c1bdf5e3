"""Formats of measured files, one module each; a file is recognised by its content, not its name.

`READERS` is the one table of them: refusals and the table of docs/users/measured.md are written from it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rsc.measured.channel import NoColumns, Recording
from rsc.measured.formats import archive, hdf5, lvm, mat, tdms, text, uff, wav

_HEAD = 4096  # bytes that tell the format


@dataclass(frozen=True)
class Reader:
    """One format.

    name : in messages
    endings : of its files, for people; nothing is told from them
    recognises : whether the first bytes of a file are those of the format
    open : (content, path) -> what is in it, of which no numbers are taken
    names, clock, units : what is used of what the format says of its channels, in words
    library : that must be installed beside rsc
    """

    name: str
    endings: str
    recognises: Callable[[bytes], bool]
    open: Callable[[bytes, Path], Recording]
    names: str
    clock: str
    units: str
    library: str = ""


_COLUMNS = "a vector by its name, columns of a matrix as `name.1`, `name.2`"
READERS = (
    Reader(
        ".npz", ".npz, .npy", archive.recognises, lambda content, _: archive.open_archive(content), _COLUMNS,
        "a column of times, or `rate`", "none",
    ),
    Reader(
        "WAV", ".wav", wav.recognises, lambda content, _: wav.open_wav(content), "numbers from 1 on", "its rate",
        "volts over `full_scale`",
    ),
    Reader(
        "UFF-58", ".uff, .unv, .58", uff.recognises, uff.open_uff, "`ID Line 1` of the dataset",
        "start, interval or uneven abscissa of each dataset", "labels of its axes", "pyuff",
    ),
    Reader(
        "TDMS", ".tdms", tdms.recognises, lambda content, _: tdms.open_tdms(content), "`channel` or `group/channel`",
        "`wf_start_time`, `wf_start_offset`, `wf_increment` of each channel", "`unit_string`, `wf_xunit_string`", "npTDMS",
    ),
    Reader(
        "LVM", ".lvm", lvm.recognises, lambda content, _: lvm.open_lvm(content), "the line over the rows",
        "its columns of X values, else `X0` and `Delta_X`", "`Y_Unit_Label`, `X_Unit_Label`",
    ),
    Reader(
        "HDF5", ".h5, .hdf5, .nc, .mat of level 7.3", hdf5.recognises, lambda content, _: hdf5.open_hdf5(content),
        "`group/array`, columns as `group/array/1`; of a .mat `struct.field`",
        "attributes `wf_increment`, `dt`, `increment` or `interval`, and `wf_start_offset`, `t0`, `x0` or `start`",
        "attribute `units`, `unit` or `unit_string`, also `ms since ...`",
    ),
    Reader(
        "MAT", ".mat of level 5", mat.recognises, lambda content, _: mat.open_mat(content),
        f"{_COLUMNS}; fields as `struct.field`",
        "structs of Simcenter Testlab (`x_values`, `y_values`); else a column of times, or `rate`", "none",
    ),
)  # fmt: skip
TEXT = Reader(
    "text", ".csv, .txt, .dat", lambda head: True, lambda content, _: text.open_text(content),
    "the line over the numbers, with or without the unit", "a column of times, or `rate`",
    "a line of units, or with the name: `Time (ms)`, `X [um]`, `X / um`, `time_ms`",
)  # fmt: skip


def reader_of(content: bytes) -> Reader:
    """The reader of a file; a text if no other reader recognises it."""
    head = content[:_HEAD]
    return next((reader for reader in READERS if reader.recognises(head)), TEXT)


def recording_of(content: bytes, path: Path) -> Recording:
    """The recording in a file; NoColumns, which names all formats, if it has none of them."""
    reader = reader_of(content)
    if reader is TEXT and b"\0" in content[:_HEAD] and not text.is_utf16(content):
        raise NoColumns(f"is no text, {', '.join(one.name for one in READERS[:-1])} or {READERS[-1].name} file")
    return reader.open(content, path)


def table() -> str:
    """The table of formats in the documents."""
    lines = ["| format | files | names of channels | when sampled | units | needs |", "|---|---|---|---|---|---|"]
    for one in (TEXT, *READERS):
        lines.append(f"| {one.name} | {one.endings} | {one.names} | {one.clock} | {one.units} | {one.library or '-'} |")
    return "\n".join(lines) + "\n"
