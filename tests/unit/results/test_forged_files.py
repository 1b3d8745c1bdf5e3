"""Result files forged with right checksums: refused in one line before memory is taken or a command hangs; no other is read."""

import os
import time

import h5py
import numpy as np
import pytest

import forge
import rsc
from rsc.cli import main
from rsc.results.result_format import put
from rsc.study.run.verify import verify
from scenes import SCENES

MACHINE = '[rotor]\nmodel = "machine"\nfile = "{0}"\ncontact = 1\n'
MATRICES = '[rotor]\nmodel = "matrices"\nmass = "{0}"\nstiffness = "{0}"\neccentricity = [1e-6]\n'


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("forged") / "run.h5"
    rsc.simulate(rsc.Scene.from_dict(SCENES["bouncing"]), path=path)
    return path


@pytest.fixture
def path(result, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.h5").write_bytes(result.read_bytes())
    (tmp_path / "scene.toml").write_text(rsc.load(result).scene.to_toml())
    os.mkfifo(tmp_path / "pipe")
    os.mkfifo(tmp_path / "pipe.npz")
    return tmp_path / "run.h5"


def refused(path, capsys, change):
    """What every command says of the file once it is changed and summed up anew."""
    with h5py.File(path, "r+", libver="latest") as file:
        change(file)
        forge.sum_up(file)
    errors = []
    for command in (["info"], ["verify"], ["plot"]):
        started = time.process_time()
        assert main([*command, str(path)]) in (2, 4)
        errors.append(capsys.readouterr().err)
        assert time.process_time() - started < 5.0  # it does not hang; tools/forged.py holds the time when all is loaded
    assert main(["run", "scene.toml", "-o", str(path), "--resume"]) in (2, 4)
    errors.append(capsys.readouterr().err)
    assert all(error.startswith("error: ") and error.count("\n") == 1 and len(error) < 400 for error in errors)
    return errors[0]


def linked(name, link):
    def change(file):
        del file[name]
        file[name] = link

    return change


def outside(name, target):
    """The samples in a file of their own, as HDF5 allows."""

    def change(file):
        shape, kind = file[name].shape, file[name].dtype
        del file[name]
        file.create_dataset(name, shape, kind, external=[(target, 0, h5py.h5f.UNLIMITED)])

    return change


def virtual(name, target):
    def change(file):
        layout = h5py.VirtualLayout(shape=file[name].shape, dtype=file[name].dtype)
        layout[...] = h5py.VirtualSource(target, name, shape=file[name].shape)
        del file[name]
        file.create_virtual_dataset(name, layout)

    return change


PLACES = ("time", "rotor", "normal_force", "checkpoint", "checkpoint/x", "checkpoint/rows", "blocks", "blocks/checksums", "axis")
LINKS = {f"{name} soft": linked(name, h5py.SoftLink("/speed")) for name in PLACES}
LINKS |= {f"{name} to a pipe": linked(name, h5py.ExternalLink("pipe", "/")) for name in PLACES}
LINKS |= {f"{name} to itself": linked(name, h5py.SoftLink(f"/{name}")) for name in PLACES}
STORED = ("time", "rotor", "checkpoint/x", "axis")
LINKS |= {f"{name} stored in {target}": outside(name, target) for name in STORED for target in ("pipe", "/dev/zero")}
LINKS |= {f"{name} virtual": virtual(name, "pipe") for name in ("time", "rotor", "checkpoint/x", "blocks/checksums")}


@pytest.mark.parametrize("change", [pytest.param(c, id=name) for name, c in LINKS.items()])
def test_links_and_arrays_elsewhere_are_refused_and_not_followed(path, capsys, change):
    """A pipe that is opened would hang: nobody writes to it."""
    refused(path, capsys, change)


@pytest.mark.parametrize("table", [MACHINE, MATRICES])
@pytest.mark.parametrize("name", ["pipe", "/dev/zero", "model.npz", "pipe.npz"])
def test_the_scene_of_a_result_reads_no_file(path, capsys, table, name):
    np.savez("model.npz", mass=np.eye(1), stiffness=np.eye(1))

    def change(file):
        stator = file.attrs["scene"].decode().partition("[stator]")
        put(file.attrs, {"scene": table.format(name) + "".join(stator[1:])})

    assert "the scene of a result" in refused(path, capsys, change)


def rows_declared(number):
    def change(file):
        for name in ("time", "speed", "rotor", "stator", "normal_force", "friction_force", "tangential_velocity"):
            file[name].resize(number, axis=0)
        file["blocks/checksums"][-1, 0] = number

    return change


def ends(values):
    def change(file):
        file["blocks/checksums"].resize(len(values), axis=0)
        file["blocks/checksums"][:, 0] = values

    return change


def replaced(name, values):
    def change(file):
        forge.as_written(file, name, values(file[name][...]))

    return change


def attribute(name, value):
    def change(file):
        file.attrs[name] = value

    return change


def many_groups(file):
    for i in range(2000):
        file.create_group(f"g{i}")


def many_attributes(file):
    for i in range(500):
        file.attrs[f"more{i}"] = i


def sample(name, value):
    def change(file):
        file[name][3] = value

    return change


FORGED = {
    **{f"{number} rows": rows_declared(number) for number in (10**9, 2**61)},
    **{f"blocks end at {values}": ends(values) for values in ([0], [-1], [2**62], [50, 20], [-5, 801])},
    "rotor wider": replaced("rotor", lambda v: np.concatenate([v, v], axis=1)),
    "rotor as f4": replaced("rotor", lambda v: v.astype("f4")),
    "time as integers": replaced("time", lambda v: v.astype("i8")),
    "forces in columns": replaced("normal_force", lambda v: v[:, None]),
    "checkpoint of 1e5 numbers": replaced("checkpoint/x", lambda v: np.zeros((len(v), 100_000))),
    "checkpoints without rows": replaced("checkpoint/x", lambda v: v[:0]),
    "many groups": many_groups,
    "many attributes": many_attributes,
    "title of another scene": attribute("title", np.bytes_(b"x" * 60_000)),
    "array for a text": attribute("advice", np.zeros((200, 2))),
    "lines in the advice": attribute("advice", np.bytes_(b"a\nb")),
    "escapes in the versions": attribute("versions", np.bytes_(b"\x1b[31m")),
    **{f"steps {value}": attribute("steps", np.int64(value)) for value in (-1, 2**63 - 1)},
    **{f"end_time {value}": attribute("end_time", value) for value in (-1.0, np.nan, np.inf, 1e9, 0.1)},
    "rtol nan": attribute("rtol", np.nan),
    "rotor not finite": sample("rotor", np.nan),
    "time turned back": sample("time", 0.0),
    "speed of another scene": sample("speed", 1.0),
}  # fmt: skip


@pytest.mark.parametrize("change", [pytest.param(c, id=name) for name, c in FORGED.items()])
def test_what_no_run_writes_is_refused(path, capsys, change):
    """By the first command that needs it, with what the scene says in mind."""
    with h5py.File(path, "r+", libver="latest") as file:
        change(file)
        forge.sum_up(file)
    with pytest.raises((rsc.DataError, rsc.SceneError)) as caught:
        for name in ("rotor", "time", "speed", "normal_force"):
            getattr(rsc.load(path), name)
        rsc.simulate(rsc.load(path).scene, path=path, resume=True)
        verify(path)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 400
    for command in ("info", "plot", "verify"):
        assert main([command, str(path)]) in (0, 2, 4)


def left_by_a_kill(path, change):
    """The result as a kill would have left it before its summary, changed."""
    with h5py.File(path, "r+", libver="latest") as file:
        for name in set(file.attrs) - {"format", "title", "scene", "versions", "checksum"}:
            del file.attrs[name]
        change(file)
        forge.sum_up(file)
    os.rename(path, f"{path}.part")


STATES = {
    "wider vectors": replaced("checkpoint/x", lambda v: np.concatenate([v, v, v, v], axis=1)),
    "negative samples": replaced("checkpoint/count", lambda v: np.full_like(v, -1)),
    "huge counts": replaced("checkpoint/count", lambda v: np.full_like(v, 2**62)),
    "steps that are no number": replaced("checkpoint/real", lambda v: np.full_like(v, np.nan)),
    "endless steps": replaced("checkpoint/real", lambda v: np.full_like(v, 1e300)),
    "impossible code": replaced("checkpoint/code", lambda v: np.full_like(v, -9)),
}


@pytest.mark.parametrize("change", [pytest.param(c, id=name) for name, c in STATES.items()])
def test_a_forged_state_never_reaches_the_kernel(path, capsys, change):
    """Wider vectors and negative counts ended with SIGSEGV."""
    left_by_a_kill(path, change)
    assert main(["run", "scene.toml", "-o", str(path), "--resume"]) in (2, 4)
    error = capsys.readouterr().err
    assert error.startswith("error: ") and error.count("\n") == 1


@pytest.mark.parametrize("row", [-1, -2])
def test_a_possible_state_that_the_run_does_not_come_to_is_not_continued(path, capsys, row, monkeypatch):
    def faster(file):
        file["checkpoint/v"][row] *= 1.0 + 1e-9

    monkeypatch.setattr("rsc.simulation.run.CHUNK_STEPS", 1000)
    rsc.simulate(rsc.load(path).scene, path=path)
    left_by_a_kill(path, faster)
    command = ["run", "scene.toml", "-o", str(path), "--resume"]
    assert main(command) == 4 and "does not follow from the one before it or from the scene" in capsys.readouterr().err
    assert main([*command, "--not-bitwise"]) == 0


def test_the_unforged_state_continues(path, capsys):
    left_by_a_kill(path, lambda file: None)
    assert main(["run", "scene.toml", "-o", str(path), "--resume"]) == 0 and main(["verify", str(path)]) == 0


@pytest.mark.parametrize("stored", [False, True])
def test_arrays_of_a_result_cannot_be_written(path, stored):
    """Changed in memory they would be saved as a finished run, with checksums."""
    result = rsc.load(path) if stored else rsc.simulate(rsc.Scene.from_dict(SCENES["bouncing"]))
    for name in ("time", "speed", "rotor", "stator", "normal_force", "friction_force", "tangential_velocity"):
        values = getattr(result, name)
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 1.0
        with pytest.raises(ValueError, match="WRITEABLE"):
            values.flags.writeable = True
        assert values.copy().flags.writeable
