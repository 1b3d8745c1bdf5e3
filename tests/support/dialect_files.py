"""WAV, UFF-58, TDMS, MAT, HDF5 and NumPy's files as several programs write them: dialects of dialects.py."""

import struct
import warnings

import h5py
import nptdms
import numpy as np
import pyuff
import scipy.io
import scipy.io.wavfile

from dialects import RATE, TIME, Table, by, dialect, probe, pulses, signals

NUMBERS = Table(("1", "2", "3"), unit='unit = "1 mm"')
BEGIN = np.datetime64("2024-05-01T10:00:00.000000")
PEAK = (b"PEAK", struct.pack("<II", 1, 0) + 3 * struct.pack("<fI", 1.0, 0))


def millimetres(scale=1e-3):
    """(n, 3) channels that fit a WAV file: mm of the probes, and pulses of -0.5."""
    return np.column_stack([scale * probe(45), scale * probe(135), 0.05 * pulses()])


# WAV


def riff(form, data, before=(), after=(), kind=b"RIFF"):
    order = ">" if kind == b"RIFX" else "<"
    chunks = [*before, (b"fmt ", form), (b"data", data), *after]
    body = b"WAVE" + b"".join(
        name + struct.pack(order + "I", len(part)) + part + b"\0" * (len(part) % 2) for name, part in chunks
    )
    return kind + struct.pack(order + "I", len(body)) + body


def fmt(tag, width, channels=3, order="<", more=b""):
    rate, block = int(RATE), channels * width
    return struct.pack(order + "HHIIHH", tag, channels, rate, rate * block, block, 8 * width) + more


def wav(name, content, table=NUMBERS, refused=""):
    dialect(name, "run.wav", table, refused)(lambda path: path.write_bytes(content()))


def scipys(name, kind, scale, table=NUMBERS):
    values = lambda: np.round(millimetres() * scale).astype(kind) if scale != 1 else millimetres().astype(kind)  # noqa: E731
    dialect(name, "run.wav", table)(lambda path: scipy.io.wavfile.write(path, int(RATE), values()))


def _eight_bits():
    return riff(fmt(1, 1), np.round(128 + 127 * 2.5 * millimetres().clip(-0.4, 0.4)).astype("u1").tobytes())


def _twenty_four_bits():
    whole = np.round(millimetres() * (2**23 - 1)).astype("<i4")
    return riff(fmt(1, 3), whole.reshape(-1, 1).view("u1").reshape(-1, 4)[:, :3].tobytes())


def _floats(order="<"):
    return millimetres().astype(order + "f4").tobytes()


EXTENSIBLE = struct.pack("<HHI", 22, 32, 7) + b"\x03\0\0\0\0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71"
scipys("WAV, 16 bits", "i2", 32767)
scipys("WAV, 32 bits", "i4", 2**31 - 1)
scipys("WAV, floats", "f4", 1)
scipys("WAV, doubles", "f8", 1)
wav("WAV, 8 bits", _eight_bits, Table(("1", "2", "3"), unit='unit = "0.4 mm"'))
wav("WAV, 24 bits", _twenty_four_bits)
wav("WAV, floats of libsndfile", lambda: riff(fmt(3, 4, more=b"\0\0"), _floats(), [(b"fact", b"\0\0\0\0")], [PEAK]))
wav("WAV, PEAK before the data", lambda: riff(fmt(3, 4), _floats(), [PEAK]))
wav("WAV, of broadcasters", lambda: riff(fmt(3, 4), _floats(), [(b"bext", bytes(602)), (b"iXML", b"<a/>"), (b"JUNK", bytes(27))]))
wav(
    "WAV, with cues and tags",
    lambda: riff(fmt(3, 4), _floats(), [], [(b"cue ", bytes(4)), (b"LIST", b"INFO"), (b"id3 ", b"ID3")]),
)
wav("WAV, extensible", lambda: riff(fmt(0xFFFE, 4, more=EXTENSIBLE), _floats()))
wav("WAV, the other order", lambda: riff(fmt(3, 4, order=">"), _floats(">"), kind=b"RIFX"))
wav("WAV, cut off", lambda: riff(fmt(3, 4), _floats())[:-5000], refused="cannot be read as WAV")
wav("WAV, packed as telephones do", lambda: riff(fmt(7, 1), bytes(24000)), refused="cannot be read as WAV")
wav(
    "WAV, rate beside the table",
    lambda: riff(fmt(3, 4), _floats()),
    Table(("1", "2", "3"), by(rate=5000.0), 'unit = "1 mm"'),
    "left out, or the 4000 Hz",
)


# UFF-58

AXES = {"abscissa_spec_data_type": 17, "orddenom_spec_data_type": 0, "rsp_node": 7, "rsp_dir": 1, "ref_node": 0, "ref_dir": 0}


USUAL = {
    "binary": False,
    "kind": 4,
    "late": (0.0, 0.0, 0.0),
    "unit": "NONE",
    "what": 8,
    "uneven": False,
    "extra": "",
    "second": 1.0,
}


def uff(name, table=None, refused="", told="", **how):
    binary, kind, late, unit, what, uneven, extra, second = (USUAL | how).values()

    def write(path):
        for (channel, angle), begin in zip((("X", 45), ("Y", 135), ("KPH", None)), late, strict=True):
            t = TIME + begin
            values = pulses(t) if angle is None else probe(angle, t)
            heads = AXES | {
                "func_type": 1,
                "abscissa_spacing": 0 if uneven else 1,
                "abscissa_inc": 0.0 if uneven else 1.0 / RATE / second,
            }
            heads |= {
                "abscissa_min": begin / second,
                "abscissa_axis_units_lab": "s" if second == 1.0 else "ms",
                "ord_data_type": kind,
                "ordinate_spec_data_type": what,
            }
            heads |= {"ordinate_axis_units_lab": "V" if angle is None else unit}
            if binary:
                heads |= {"spec_data_type": 0, "byte_ordering": 1, "fp_format": 2, "n_ascii_lines": 11, "n_bytes": 8 * len(t)}
            one = pyuff.prepare_58(binary=int(binary), id1=channel, data=values, x=t / second, **heads)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ResourceWarning)  # it leaves a file open while it writes
                pyuff.UFF(str(path)).write_sets(one, "add", force_double=kind == 4)
        if extra:
            path.write_text(extra + path.read_text())

    dialect(name, "run.uff", table or Table(), refused, told)(write)


UNITS = f"{-1:6d}\n{164:6d}\n{1:10d}{'SI':>20}{2:10d}\n" + "  1.0D+00  1.0D+00  1.0D+00\n  2.7D+02\n" + f"{-1:6d}\n"
uff("UFF-58, text")
uff("UFF-58, text of single precision", kind=2)
uff("UFF-58, binary", binary=True)
uff("UFF-58 with a unit", Table(unit=""), unit="um")
uff("UFF-58 of channels that began apart", late=(0.0, 0.0133, 0.0052), told="start times")
uff("UFF-58, uneven times", uneven=True)
uff("UFF-58, milliseconds", second=1e-3, late=(0.0, 0.0133, 0.0), told="start times")
uff("UFF-58 with units of its own", extra=UNITS, told="dataset 164")
uff("UFF-58 of accelerations", what=12, refused="an acceleration")
uff("UFF-58 with another unit", unit="mm", refused="left out, or the 0.001 m")


# TDMS


def tdms(name, make, table=None, refused="", told=""):
    def write(path):
        with nptdms.TdmsWriter(str(path)) as file:
            for segment in make():
                file.write_segment(segment)

    dialect(name, "run.tdms", table or Table(), refused, told)(write)


def channel(name, values, rate=RATE, group="rig", **more):
    return nptdms.ChannelObject(group, name, np.asarray(values), properties={"wf_increment": 1.0 / rate, **more})


def began(late=0.0, **more):
    return {"wf_start_time": BEGIN + np.timedelta64(round(late * 1e6), "us"), "wf_start_offset": 0.0, **more}


def waveforms(late=(0.0, 0.0, 0.0), unit="", **more):
    made = []
    for (name, angle), begin in zip((("X", 45), ("Y", 135), ("KPH", None)), late, strict=True):
        values = pulses(TIME + begin) if angle is None else probe(angle, TIME + begin)
        made.append(channel(name, values, **began(begin, unit_string="V" if angle is None else unit), **more))
    return [made]


def _slow_speed():
    slow = np.arange(0.0, 2.0 + 1e-9, 0.02)
    return [[*waveforms()[0][:2], channel("n", 60.0 * (40.0 + 2.5 * slow), 50.0, **began(unit_string="rpm"))]]


def _two_rates():
    fast = np.arange(int(4 * RATE * 2.0)) / (4 * RATE)
    x, y = (
        channel(name, probe(angle, t), rate, **began())
        for name, angle, t, rate in (("X", 45, fast, 4 * RATE), ("Y", 135, TIME, RATE))
    )
    return [[x, y, channel("KPH", pulses(fast), 4 * RATE, **began())]]


def _scaled():
    whole = {name: np.round(values / 0.02).astype("i2") for name, values in signals().items()}
    scale = {"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Linear", "NI_Scale[0]_Linear_Slope": 0.02}
    scale |= {"NI_Scale[0]_Linear_Y_Intercept": 0.0, "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF}
    return [[channel(name, values, **scale) for name, values in whole.items()]]


def _pieces():
    parts = {name: np.array_split(values, 7) for name, values in signals().items()}
    return [[channel(name, pieces[i]) for name, pieces in parts.items()] for i in range(7)]


def _bare(**columns):
    return [[nptdms.ChannelObject("rig", name, values) for name, values in columns.items()]]


tdms("TDMS, waveforms", waveforms)
tdms("TDMS, waveforms in um", lambda: waveforms(unit="um"), Table(unit=""))
tdms("TDMS, called with the group", waveforms, Table(("rig/X", "rig/Y", "rig/KPH")))
tdms("TDMS, a module that began later", lambda: waveforms((0.0, 0.0074, 0.0)), told="start times")
tdms("TDMS, a Keyphasor that began later", lambda: waveforms((0.0, 0.0, 0.00513)), told="start times")
tdms(
    "TDMS, a start offset",
    lambda: [
        [channel("X", probe(45)), channel("Y", probe(135, TIME + 0.0101), wf_start_offset=0.0101), channel("KPH", pulses())]
    ],
    told="start times",
)
tdms("TDMS, pieces", _pieces)
tdms("TDMS, scaled whole numbers", _scaled)
tdms("TDMS, floats", lambda: [[channel(name, values.astype("f4")) for name, values in signals().items()]])
tdms("TDMS, a slow speed", _slow_speed, Table(("X", "Y", "n"), shaft="speed"), told="no Keyphasor")
tdms("TDMS, a slow channel beside", lambda: [[*waveforms()[0], channel("oil", np.ones(20), 10.0)]])
tdms("TDMS, probes of two rates", _two_rates, told="not one rate")
tdms("TDMS, no waveforms, by the rate", lambda: _bare(**signals()), Table(more=by(rate=RATE)))
tdms("TDMS, no waveforms, by times", lambda: _bare(t=TIME, **signals()), Table(more=by(time="t")))
tdms("TDMS, no waveforms", lambda: _bare(**signals()), refused="measured.rate")
tdms(
    "TDMS, words as an increment",
    lambda: [[channel(n, v, wf_increment="x") for n, v in signals().items()]],
    refused="wf_increment",
)
tdms("TDMS, increments in ms", lambda: [[channel(n, v, 4.0, wf_xunit_string="ms") for n, v in signals().items()]])
tdms("TDMS, spectra", lambda: [[channel(n, v, wf_xunit_string="Hz") for n, v in signals().items()]], refused="measured.rate")
tdms(
    "TDMS, two groups of the same names",
    lambda: [[*waveforms()[0], *(channel(n, 0.0 * v, group="old") for n, v in signals().items())]],
    Table(("rig/X", "rig/Y", "rig/KPH")),
)
tdms("TDMS, two groups, names alone", lambda: [[*waveforms()[0], channel("X", 0.0 * TIME, group="old")]], refused="2 columns 'X'")
tdms("TDMS, runs of two days", lambda: waveforms((0.0, 86400.0, 0.0)), refused="not known together")
tdms(
    "TDMS, a rate mistyped",
    lambda: [[channel("X", probe(45)), channel("Y", probe(135), 4001.0), channel("KPH", pulses())]],
    refused="run apart",
)
tdms(
    "TDMS, samples lost",
    lambda: [[channel("X", probe(45)), channel("Y", probe(135)[:-9]), channel("KPH", pulses())]],
    refused="not one length",
)


# NumPy


def npz(name, make, table=None, refused="", told="", file="run.npz", save=np.savez):
    def write(path):
        made = make()
        np.save(path, made) if isinstance(made, np.ndarray) else save(path, **made)

    dialect(name, file, table or Table(more=by(time="t")), refused, told)(write)


MATRIX = Table(("data.2", "data.3", "data.4"), by(time="data.1"))
npz("NumPy, vectors", lambda: {"t": TIME, **signals()})
npz("NumPy, packed", lambda: {"t": TIME, **signals()}, save=np.savez_compressed)
npz(
    "NumPy, whole numbers",
    lambda: {"t": TIME, **{n: np.round(50 * v).astype("i2") for n, v in signals().items()}},
    Table(more=by(time="t"), unit='unit = "0.02 um"'),
)
npz("NumPy, floats of the other order", lambda: {"t": TIME, **{n: v.astype(">f4") for n, v in signals().items()}})
npz("NumPy, a matrix", lambda: {"data": np.column_stack([TIME, *signals().values()]), "fs": np.array(RATE)}, MATRIX)
npz("NumPy, a matrix lying down", lambda: {"data": np.array([TIME, *signals().values()])}, MATRIX)
npz(
    "NumPy, one array", lambda: np.column_stack([TIME, *signals().values()]), Table(("2", "3", "4"), by(time="1")), file="run.npy"
)
npz("NumPy, one array of a signal", lambda: TIME, refused="single array", file="run.npy")
npz("NumPy, lengths that differ", lambda: {"t": TIME[:-1], **signals()}, refused="not one length")
npz("NumPy, complex numbers", lambda: {"t": TIME, **{n: v + 0j for n, v in signals().items()}}, refused="no column 'X'")


# MAT and HDF5


def mat(name, make, table=None, refused="", told="", **how):
    dialect(name, "run.mat", table or Table(more=by(time="t")), refused, told)(lambda path: scipy.io.savemat(path, make(), **how))


def _testlab():
    values = np.column_stack(list(signals().values()))
    return {"Signal": {"x_values": {"start_value": 0.0, "increment": 1.0 / RATE}, "y_values": {"values": values}}}


SIMCENTER = Table(tuple(f"Signal.y_values.values.{i}" for i in (1, 2, 3)))
mat("MAT, vectors", lambda: {"t": TIME, **signals()}, oned_as="column")
mat("MAT, rows", lambda: {"t": TIME, **signals()}, oned_as="row")
mat("MAT, packed", lambda: {"t": TIME, **signals()}, do_compression=True)
mat(
    "MAT, whole numbers",
    lambda: {"t": TIME, **{n: np.round(50 * v).astype("i2") for n, v in signals().items()}},
    Table(more=by(time="t"), unit='unit = "0.02 um"'),
)
mat("MAT, a matrix", lambda: {"data": np.column_stack([TIME, *signals().values()])}, MATRIX)
mat(
    "MAT, a struct",
    lambda: {"run": {"t": TIME, "words": "bench 3", **signals()}},
    Table(("run.X", "run.Y", "run.KPH"), by(time="run.t")),
)
mat("MAT, with a rate beside", lambda: {"fs": RATE, **signals()}, Table(more=by(rate=RATE)), told="fs = 4000")
mat("MAT, of Simcenter Testlab", _testlab, SIMCENTER)
mat("MAT, without times", signals, Table(), refused="measured.rate")
mat("MAT, level 4", lambda: {"t": TIME, **signals()}, refused="no text", format="4")


def hdf(name, write, table=None, refused="", told="", file="run.h5", **how):
    def whole(path):
        with h5py.File(path, "w", **how) as out:
            write(out)
        if how:
            with open(path, "r+b") as out:
                out.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")

    dialect(name, file, table or Table(more=by(time="t")), refused, told)(whole)


def put(file, prefix="", attributes=None, change=lambda values: values, time=True, **how):
    for name, values in (({"t": TIME} if time else {}) | signals()).items():
        made = file.create_dataset(prefix + name, data=change(values) if name != "t" else values, **how)
        made.attrs.update((attributes or {}) if name in "XY" else {})


def _as_npTDMS(file):
    for name, late in (("X", 0.0), ("Y", 0.0074), ("KPH", 0.0)):
        t = TIME + late
        made = file.create_dataset(f"rig/{name}", data=pulses(t) if name == "KPH" else probe(45 if name == "X" else 135, t))
        made.attrs.update({"wf_increment": 1.0 / RATE, "wf_start_offset": late, "unit_string": "V" if name == "KPH" else "um"})


def in_milliseconds(file):
    put(file, time=False)
    file.create_dataset("t", data=1e3 * TIME).attrs["units"] = "milliseconds since 2024-05-01T10:00:00"


def _packed(values):
    return np.round((values - 5.0) / 0.02).astype("i2")


def _level_73(file, prefix=""):
    for name, values in ({"t": TIME} | signals()).items():
        file.create_dataset(prefix + name, data=values[None, :]).attrs["MATLAB_class"] = np.bytes_("double")


RIG = Table(("rig/X", "rig/Y", "rig/KPH"), unit="")
hdf("HDF5, vectors", put)
hdf("HDF5, a group", lambda file: put(file, "rig/"), Table(("rig/X", "rig/Y", "rig/KPH"), by(time="rig/t")))
hdf("HDF5, units", lambda file: put(file, attributes={"units": "um"}), Table(more=by(time="t"), unit=""))
hdf(
    "HDF5, units of a fixed length",
    lambda file: put(file, attributes={"unit": np.bytes_("um")}),
    Table(more=by(time="t"), unit=""),
)
hdf("HDF5, packed", lambda file: put(file, compression="gzip", shuffle=True, fletcher32=True))
hdf("HDF5, packed by LZF", lambda file: put(file, compression="lzf"))
hdf("HDF5, floats of the other order", lambda file: put(file, change=lambda values: values.astype(">f4")))
hdf(
    "HDF5, packed as netCDF files are",
    lambda file: put(
        file, attributes={"scale_factor": 0.02, "add_offset": 5.0}, change=lambda v: _packed(v) if np.ptp(v) > 11 else v
    ),
)
hdf(
    "HDF5, a matrix",
    lambda file: file.create_dataset("data", data=np.column_stack([TIME, *signals().values()])),
    Table(("data/2", "data/3", "data/4"), by(time="data/1")),
)
hdf("HDF5, as npTDMS exports", _as_npTDMS, RIG, told="start times")
hdf("HDF5, milliseconds", in_milliseconds)
hdf("HDF5, a factor in words", lambda file: put(file, attributes={"scale_factor": "two"}), refused="scale_factor")
hdf("HDF5, another unit", lambda file: put(file, attributes={"units": "mm"}), refused="left out, or the 0.001 m")
hdf("MAT, level 7.3", _level_73, file="run.mat", userblock_size=512)
hdf(
    "MAT, level 7.3, a struct",
    lambda file: _level_73(file, "run/"),
    Table(("run.X", "run.Y", "run.KPH"), by(time="run.t")),
    file="run.mat",
    userblock_size=512,
)
