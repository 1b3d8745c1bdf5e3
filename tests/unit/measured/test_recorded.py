"""Measured runs in the files of laboratories, UFF-58 and TDMS, written by the packages that others read them with."""

import sys

import nptdms
import numpy as np
import pytest

import rsc
from laboratories import write_tdms, write_uff
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


def write(folder, kind):
    """(the table of a run in such a file, that file)."""
    table = written(folder, TIME, MOTION, pulses_of(TURNS))
    path = folder / f"run.{kind[:4].strip()}"
    table.write_text(table.read_text().replace('time = "t"\n', "").replace("run.csv", path.name))
    if kind == "tdms":
        write_tdms(path, SIGNALS, RATE)
    else:
        write_uff(path, SIGNALS, RATE, binary=kind != "uff")
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
    write_uff(path, again, RATE)
    table.write_text(table.read_text().replace('"X"', '"1"').replace('"Y"', '"2"').replace('"KPH"', '"3"'))
    np.testing.assert_array_equal(rsc.read_measured(table).deflection, wanted.deflection)


def test_channels_of_several_groups_and_pieces_are_joined(tmp_path):
    table, path = write(tmp_path, "tdms")
    wanted = rsc.read_measured(table)
    write_tdms(path, SIGNALS, RATE, groups="abc", pieces=5)
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
    "lengths": ("uff", lambda path: write_uff(path, shorter(), RATE), "not one length (X 12000, Y 12000, KPH 11993)"),
    "rates": ("uff", lambda path: write_uff(path, SIGNALS, RATE, RATE, 2000.0), "not one rate"),
    "spectra": ("uff", lambda path: write_uff(path, SIGNALS, RATE, function=2), "0 time responses"),
    "cut off": ("uff", lambda path: path.write_bytes(path.read_bytes()[:-3000] + b"\n    -1\n"), "is cut off"),
    "no dataset": ("uff", lambda path: path.write_text("    -1\n   151\nhello\n    -1\n"), "0 time responses"),
    "lines": ("uff", lambda path: path.write_bytes(b"    -1\n    58\n" + b"\n" * 2_100_000), "2000000 lines"),
    "lengths of channels": ("tdms", lambda path: write_tdms(path, shorter(), RATE), "not one length"),
    "rates of channels": ("tdms", lambda path: write_tdms(path, SIGNALS, 1.0, 1.0, 2.0), "not one rate"),
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
