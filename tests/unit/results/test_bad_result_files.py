"""Result files that no run wrote: another format, another program's, changed inside, hostile: refused in one line.

Numbers in the ids are the rows of the project's list of bad inputs (group D: result files, group E: hostile).
"""

import os
import pickle
import time

import h5py
import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.results.result_format import FORMAT, digest, put
from scenes import SCENES

FOREIGN = {
    "D61 zero length": b"",
    "D62 npz": b"PK\x03\x04" + bytes(200),
    "D62 text": b"time,rotor\n0,1\n",
    "E66 pickle": pickle.dumps({"time": [0.0]}),
}


@pytest.fixture(scope="module", autouse=True)
def imported(tmp_path_factory):
    """The commands with their modules, whose import takes seconds on a slow file system and is no part of a refusal."""
    for command in ("info", "plot", "verify"):
        main([command, str(tmp_path_factory.mktemp("none") / "none.h5")])


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    path = tmp_path_factory.mktemp("small") / "run.h5"
    rsc.simulate(rsc.Scene.from_dict(SCENES["bouncing"]), path=path)
    return path.read_bytes()


@pytest.fixture
def path(tmp_path, content):
    (tmp_path / "run.h5").write_bytes(content)
    return tmp_path / "run.h5"


def refused(path, capsys, *command):
    """The one line with which a command refuses a file in under two seconds, leaving the folder and the file alone."""
    before, names, started = path.read_bytes() if path.is_file() else None, sorted(os.listdir(path.parent)), time.process_time()
    assert main([*(command or ("info",)), str(path)]) == 4
    error = capsys.readouterr().err
    assert time.process_time() - started < 2.0
    assert error.startswith(f"error: {path}: ") and error.count("\n") == 1 and len(error) < 400
    assert sorted(os.listdir(path.parent)) == names and (before is None or path.read_bytes() == before)
    return error


@pytest.mark.parametrize("name", FOREIGN)
def test_what_is_no_hdf5_file_is_refused(name, tmp_path, capsys):
    (tmp_path / "x.h5").write_bytes(FOREIGN[name])
    for command in ("info", "plot", "verify"):
        refused(tmp_path / "x.h5", capsys, command)


def test_a_directory_is_refused(path, capsys):
    for command in ("info", "plot", "verify"):
        assert refused(path.parent, capsys, command).endswith("is a directory, wanted: a result file\n")


def test_another_programs_hdf5_file_is_refused(tmp_path, capsys):
    with h5py.File(tmp_path / "x.h5", "w") as file:
        file["time"] = np.arange(10.0)
    assert "its format is none" in refused(tmp_path / "x.h5", capsys)


OTHER_FORMATS = ["rsc-result-1", "rsc-result-3", "rsc-result-6", "rsc-result-44", "\n" * 50, b"rsc", 2, np.zeros((9, 9))]


@pytest.mark.parametrize("number", OTHER_FORMATS)
def test_another_format_is_refused_by_every_reader(path, number, capsys):
    """Old and future ones alike: what the numbers mean may have changed, so none of them is shown."""
    with h5py.File(path, "r+") as file:
        put(file.attrs, {"format": number})
    for command in ("info", "plot", "verify"):
        error = refused(path, capsys, command)
        assert f"this rsc reads '{FORMAT}'" in error
    if isinstance(number, str) and number.isprintable():
        assert repr(number) in error
    with pytest.raises(rsc.DataError, match="this rsc reads"):
        rsc.simulate(rsc.Scene.from_dict(SCENES["bouncing"]), path=path, resume=True)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_format_up_to_the_third_is_an_older_one(path, number, capsys):
    """Their texts had any length."""
    with h5py.File(path, "r+") as file:
        del file.attrs["format"]
        file.attrs["format"] = f"rsc-result-{number}"
    assert "its format is an older one" in refused(path, capsys)


def replaced(file, name, values, **options):
    del file[name]
    file.create_dataset(name, data=values, **options)


def shrunk_time(file):
    file["time"].resize(10, axis=0)


def other_type(file):
    replaced(file, "normal_force", file["normal_force"][...].astype("f4"), chunks=True, fletcher32=True)


def pickled(file):
    data = np.frombuffer(pickle.dumps(eval), dtype="u1")
    replaced(file, "normal_force", data, chunks=True, fletcher32=True)


def texts(file):
    replaced(file, "time", np.array([b"0", b"1"]), maxshape=(None,), fletcher32=True)


def one_column_less(file):
    replaced(file, "rotor", file["rotor"][:, :0, :], chunks=(4096, 1, 2), maxshape=(None, None, 2), fletcher32=True)


def three_components(file):
    replaced(file, "rotor", np.zeros((file["time"].shape[0], 1, 3)), chunks=True, fletcher32=True)


def huge(file):
    for name in ("time", "speed", "normal_force", "friction_force", "tangential_velocity"):
        file[name].resize(10**15, axis=0)
    for name in ("rotor", "stator"):
        file[name].resize(10**15, axis=0)


def bomb(file):
    for name in ("time", "speed", "normal_force", "friction_force", "tangential_velocity"):
        replaced(file, name, np.zeros(4_000_000), chunks=(4096,), compression="gzip", fletcher32=True)


def unchecked(file):
    replaced(file, "rotor", file["rotor"][...], chunks=True)


def elsewhere(file):
    del file["rotor"]
    file["rotor"] = h5py.ExternalLink("/etc/passwd", "rotor")


def virtual(file):
    layout = h5py.VirtualLayout(shape=file["rotor"].shape, dtype="f8")
    layout[:] = h5py.VirtualSource("other.h5", "rotor", shape=file["rotor"].shape)
    del file["rotor"]
    file.create_virtual_dataset("rotor", layout)


def a_group(file):
    del file["time"]
    file.create_group("time")


def a_loop(file):
    del file["time"]
    file["time"] = h5py.SoftLink("/time")


def no_force(file):
    del file["normal_force"]


def no_scene(file):
    del file.attrs["scene"]


def changed_scene(file):
    put(file.attrs, {"scene": file.attrs["scene"].decode().replace("friction = 0.2", "friction = 0.3")})


def bad_scene(file):
    put(file.attrs, {"scene": file.attrs["scene"].decode().replace("friction = ", "friction = -")})


def scene_of_code(file):
    put(file.attrs, {"scene": "__import__('os').system('touch owned')"})


def deep_scene(file):
    put(file.attrs, {"scene": "x = " + "[" * 20_000})


def dotted_scene(file):
    put(file.attrs, {"scene": "a." * 30_000 + "b = 1"})


def scene_of_any_length(file):
    file.attrs["scene"] = file.attrs["scene"].decode()


def scene_number(file):
    file.attrs["scene"] = 5


def unknown_status(file):
    put(file.attrs, {"status": "splendid"})


def status_list(file):
    file.attrs["status"] = [1, 2]


def short_ledger(file):
    file.attrs["ledger"] = [1.0]


def steps_text(file):
    put(file.attrs, {"steps": "many\nlines"})


def endless_time(file):
    file.attrs["end_time"] = np.zeros(5)


CHANGES = {
    "D64": (shrunk_time, other_type, texts, one_column_less, three_components, unchecked, a_group, no_force),
    "D scene": (no_scene, changed_scene, bad_scene, deep_scene, dotted_scene, scene_number, scene_of_any_length),
    "D summary": (unknown_status, status_list, short_ledger, steps_text, endless_time),
    "E66": (pickled,), "E67": (huge,), "E68": (bomb,), "E71": (scene_of_code,),
    "E72": (a_loop,), "E external": (elsewhere, virtual),
}  # fmt: skip


@pytest.mark.parametrize("change", [pytest.param(c, id=f"{row} {c.__name__}") for row, found in CHANGES.items() for c in found])
def test_a_file_changed_inside_is_refused(path, change, tmp_path, monkeypatch):
    """By the reader itself: the memory it may take is capped by what the file really stores."""
    resource = pytest.importorskip("resource")
    monkeypatch.chdir(tmp_path)
    with h5py.File(path, "r+", libver="latest") as file:
        change(file)
        if change is not changed_scene:  # a forger would write the checksum as well
            texts = {n: v.decode() if isinstance(v, bytes) else v for n, v in file.attrs.items()}
            put(file.attrs, {"checksum": digest(texts)})
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises((rsc.DataError, rsc.SceneError)) as caught:
        rsc.load(path)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 600
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000  # kB
    assert os.listdir(tmp_path) == ["run.h5"]


def test_the_unchanged_file_is_read(path):
    assert rsc.load(path).status == "finished"


def test_a_file_being_written_is_read_to_its_last_block(path, tmp_path):
    """D65: what another process has flushed is there, and what it declares beyond is not shown."""
    from rsc.results.result_file import ResultFile
    from rsc.results.result_writer import ResultWriter

    source = ResultFile(path)
    scene, block = source.scene(), source.block()
    with ResultWriter(tmp_path / "growing.h5", scene, "any") as writer:
        for first, last in ((0, 100), (100, 350)):
            writer.append({name: values[first:last] for name, values in block.items()})
            assert len(ResultFile(tmp_path / "growing.h5.part").series("time")) == last
        with pytest.raises(rsc.DataError, match="did not end"):
            rsc.load(tmp_path / "growing.h5.part")


@pytest.mark.posix
@pytest.mark.parametrize("name", ["run.h5", "run.h5.part"])
def test_a_link_as_output_is_refused_and_its_target_left_alone(tmp_path, name):
    """E70: nothing is written through a link, be it in the place of the result or of its file while the run goes on."""
    (tmp_path / "precious").write_text("data")
    (tmp_path / name).symlink_to(tmp_path / "precious")
    with pytest.raises(rsc.DataError, match="cannot be written"):
        rsc.simulate(rsc.Scene.from_dict(SCENES["bouncing"]), path=tmp_path / "run.h5")
    assert (tmp_path / "precious").read_text() == "data" and (tmp_path / name).is_symlink()


def test_only_a_result_is_replaced_by_a_result(tmp_path):
    scene = rsc.Scene.from_dict(SCENES["bouncing"])
    (tmp_path / "run.h5").touch()
    for _ in range(2):
        rsc.simulate(scene, path=tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["K"] = np.eye(2)
    before = (tmp_path / "run.h5").read_bytes()
    with pytest.raises(rsc.DataError, match="did not write"):
        rsc.simulate(scene, path=tmp_path / "run.h5")
    assert (tmp_path / "run.h5").read_bytes() == before and os.listdir(tmp_path) == ["run.h5"]
