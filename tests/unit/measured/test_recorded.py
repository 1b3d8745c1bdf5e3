"""Measured runs in the files of laboratories, UFF-58 and TDMS, written by the packages that others read them with."""

import sys
import warnings
from time import process_time

import nptdms
import numpy as np
import pytest
import pyuff

import rsc
from probes import pulses_of, turns_of, volts, written
from rsc.errors import DataError

RATE, SPEEDS = 4000.0, (20.0, 60.0)
TIME = np.arange(0.0, 3.0, 1.0 / RATE)
TURNS = turns_of(TIME, SPEEDS)
MOTION = 0.3e-3 * np.exp(-2j * np.pi * 31.0 * TIME) + 1e-4 * np.exp(2j * np.pi * TURNS)
SIGNALS = {
    name: values for name, values in zip(("X", "Y", "KPH"), (*volts(MOTION, (45.0, 135.0)), pulses_of(TURNS)), strict=True)
}
KINDS = "uff", "uff of binary", "tdms"


def write_uff(path, signals=SIGNALS, binary=0, rates=(RATE, RATE, RATE), function=1):
    path.unlink(missing_ok=True)
    for (name, values), rate in zip(signals.items(), rates, strict=True):
        told = {"func_type": function, "abscissa_spacing": 1, "abscissa_inc": 1.0 / rate, "ord_data_type": 4}
        axes = {"abscissa_spec_data_type": 17, "ordinate_spec_data_type": 8, "orddenom_spec_data_type": 0}
        place = {"rsp_node": 7, "rsp_dir": 1, "ref_node": 0, "ref_dir": 0}
        form = {"spec_data_type": 0, "byte_ordering": 1, "fp_format": 2, "n_ascii_lines": 11, "n_bytes": 8 * len(values)}
        heads = told | axes | place | (form if binary else {})
        data = pyuff.prepare_58(binary=binary, id1=name, data=values, x=np.arange(len(values)) / rate, **heads)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)  # it leaves a file open while it writes
            pyuff.UFF(str(path)).write_sets(data, "add", force_double=bool(binary))


def write_tdms(path, signals=SIGNALS, properties=({"wf_increment": 1.0 / RATE},) * 3, groups="aaa", pieces=1):
    channels = [
        [nptdms.ChannelObject(group, name, part, own) for part in np.array_split(values, pieces)]
        for group, (name, values), own in zip(groups, signals.items(), properties, strict=True)
    ]
    with nptdms.TdmsWriter(str(path)) as writer:
        for parts in zip(*channels, strict=True):
            writer.write_segment(parts)


def write(folder, kind):
    """(the table of a run in such a file, that file)."""
    table = written(folder, TIME, MOTION, pulses_of(TURNS))
    path = folder / f"run.{kind[:4].strip()}"
    table.write_text(table.read_text().replace('time = "t"\n', "").replace("run.csv", path.name))
    if kind == "tdms":
        write_tdms(path)
    else:
        write_uff(path, binary=int(kind != "uff"))
    return table, path


@pytest.mark.parametrize("kind", KINDS)
def test_the_files_of_laboratories_give_the_numbers_of_the_csv(tmp_path, kind):
    wanted = rsc.read_measured(written(tmp_path, TIME, MOTION, pulses_of(TURNS)))
    run = rsc.read_measured(write(tmp_path, kind)[0])
    np.testing.assert_allclose(run.time, wanted.time, atol=1e-9)
    np.testing.assert_allclose(run.deflection, wanted.deflection, atol=1e-8)
    np.testing.assert_allclose(run.speed, wanted.speed, atol=1e-3)


def test_channels_are_called_by_numbers_where_their_names_repeat(tmp_path):
    table, path = write(tmp_path, "uff")
    wanted = rsc.read_measured(table)
    again = dict(zip((" same", "same ", "same"), SIGNALS.values(), strict=True))
    write_uff(path, again)
    table.write_text(table.read_text().replace('"X"', '"1"').replace('"Y"', '"2"').replace('"KPH"', '"3"'))
    np.testing.assert_array_equal(rsc.read_measured(table).deflection, wanted.deflection)


def test_channels_of_several_groups_and_pieces_are_joined(tmp_path):
    table, path = write(tmp_path, "tdms")
    wanted = rsc.read_measured(table)
    write_tdms(path, groups="abc", pieces=5)
    np.testing.assert_array_equal(rsc.read_measured(table).deflection, wanted.deflection)
    channels = [nptdms.ChannelObject(group, "s", values) for group, values in zip("abc", SIGNALS.values(), strict=True)]
    with nptdms.TdmsWriter(str(path)) as writer:  # no waveforms: the rate stands in the table
        writer.write_segment([*channels, nptdms.ChannelObject("c", "words", ["hot", "cold"])])
    content = table.read_text().replace("[measured]", "[measured]\nrate = 4000.0")
    table.write_text(content.replace('"X"', '"a/s"').replace('"Y"', '"b/s"').replace('"KPH"', '"c/s"'))
    np.testing.assert_array_equal(rsc.read_measured(table).deflection, wanted.deflection)


def shorter(signals=SIGNALS):
    return signals | {"KPH": signals["KPH"][:-7]}


BAD = {
    "lengths": ("uff", lambda path: write_uff(path, shorter()), "not one length (X 12000, Y 12000, KPH 11993)"),
    "rates": ("uff", lambda path: write_uff(path, rates=(RATE, RATE, 2000.0)), "not one rate"),
    "spectra": ("uff", lambda path: write_uff(path, function=2), "0 time responses"),
    "cut off": ("uff", lambda path: path.write_bytes(path.read_bytes()[:-3000] + b"\n    -1\n"), "is cut off"),
    "no dataset": ("uff", lambda path: path.write_text("    -1\n   151\nhello\n    -1\n"), "0 time responses"),
    "lines": ("uff", lambda path: path.write_bytes(b"    -1\n    58\n" + b"\n" * 2_100_000), "2000000 lines"),
    "lengths of channels": ("tdms", lambda path: write_tdms(path, shorter()), "not one length"),
    "rates of channels": (
        "tdms", lambda path: write_tdms(path, properties=[{"wf_increment": step} for step in (1.0, 1.0, 2.0)]), "not one rate"
    ),
    "cut off tdms": ("tdms", lambda path: path.write_bytes(path.read_bytes()[:-90_000]), "is cut off"),
    "pieces": ("tdms", lambda path: path.write_bytes(path.read_bytes() + b"TDSm" * 200_001), "segments"),
    "no tdms": ("tdms", lambda path: path.write_bytes(b"TDSm" + bytes(400)), "cannot be read as TDMS"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_files_without_channels_alike_are_refused_in_one_line(tmp_path, name, capfd):
    kind, spoil, wanted = BAD[name]
    table, path = write(tmp_path, kind)
    spoil(path)
    with pytest.raises(DataError) as error:
        rsc.read_measured(table)
    assert wanted in str(error.value) and "\n" not in str(error.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("kind", "module"), [("uff", "pyuff"), ("tdms", "nptdms")])
def test_an_absent_reader_is_named_with_how_to_get_it(tmp_path, monkeypatch, kind, module):
    table, _ = write(tmp_path, kind)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(DataError, match=r'pip install "rotor-stator-contact\[measured\]"'):
        rsc.read_measured(table)


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_files_are_read_or_refused_and_nothing_else(tmp_path, kind):
    rng, ends = np.random.default_rng(5), {"read": 0, "refused": 0}
    table, path = write(tmp_path, kind)
    small = {name: values[:400] for name, values in (SIGNALS | {"KPH": pulses_of(TURNS, 10)}).items()}
    if kind == "tdms":
        write_tdms(path, small, pieces=3)
    else:
        write_uff(path, small, binary=int(kind != "uff"))
    table.write_text(table.read_text().replace("[measured]", "[measured]\nevents_per_turn = 10"))
    good = path.read_bytes()
    for number in range(250):
        content = bytearray(good)
        reach = len(content) if number % 2 else min(1200, len(content))  # half of them in the head
        for place in rng.integers(0, reach, rng.integers(1, 6)):
            content[place] = rng.integers(0, 256)
        cut = rng.integers(0, len(content)) if rng.random() < 0.2 else len(content)
        path.write_bytes(content[:cut])
        began = process_time()
        try:
            run = rsc.read_measured(table)
        except DataError as error:
            assert "\n" not in str(error)
            ends["refused"] += 1
        else:
            assert run.time.shape == run.speed.shape == run.deflection.shape == run.turns.shape
            ends["read"] += 1
        assert process_time() - began < 5.0
    assert min(ends.values()) > 0
