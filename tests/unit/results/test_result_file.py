"""Result files under faults: kills, full disks, damage, two writers; nothing wrong is ever read, nothing saved is lost."""

import os
import random
import resource
import signal
import subprocess
import sys
import time
from dataclasses import replace

import h5py
import numpy as np
import pytest

import rsc
import rsc.study.run.verify
from rsc.cli import main
from rsc.results.result_format import BLOCKS, STRETCHES
from rsc.results.result_writer import ResultWriter
from rsc.results.summary import Status
from rsc.simulation.run import Run
from rsc.study.run.start import run_of
from scenes import SCENES
from systems import reference_scene

ARRAYS = ("time", "speed", "rotor", "stator", "normal_force", "friction_force", "tangential_velocity")


def same(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ARRAYS)


@pytest.fixture(scope="module")
def long_run():
    """A run of some seconds and its scene."""
    scene = reference_scene("bouncing").with_values({"drive.duration": 400.0})
    return scene, rsc.simulate(scene)


@pytest.fixture
def scene_file(tmp_path, monkeypatch, long_run):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "long.toml").write_text(long_run[0].to_toml())
    return tmp_path / "long.toml"


def started(*more, **options):
    command = [sys.executable, "-m", "rsc", "run", "long.toml", "-o", "run.h5", *more]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, **options)


def wait_for_samples(process, part, size):
    deadline = time.monotonic() + 60.0
    since = time.time()
    while process.poll() is None and not (part.exists() and part.stat().st_mtime > since and part.stat().st_size > size):
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_kills_at_random_moments_lose_nothing(scene_file, tmp_path, long_run):
    """kill -9 again and again; the run that is resumed each time ends with the same bits as the one left alone."""
    part, moments, killed = tmp_path / "run.h5.part", random.Random(3), 0
    for attempt in range(5):
        process = started(*(["--resume"] if attempt else []))
        wait_for_samples(process, part, 30_000)
        time.sleep(moments.uniform(0.0, 0.3))
        killed += process.poll() is None
        process.kill()
        process.communicate()
    assert killed >= 3
    assert main(["run", "long.toml", "-o", "run.h5", "--resume"]) == 0
    again = rsc.load("run.h5")
    assert same(again, long_run[1]) and again.summary == long_run[1].summary
    assert sorted(p.name for p in tmp_path.iterdir()) == ["long.toml", "run.h5"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupted_run_is_readable_and_goes_on(scene_file, tmp_path, long_run, number):
    process = started()
    wait_for_samples(process, tmp_path / "run.h5.part", 200_000)
    process.send_signal(number)
    if number == signal.SIGHUP:  # sent by the terminal and once more by its shell
        process.send_signal(number)
    asked = time.monotonic()
    process.communicate(timeout=20.0)
    assert process.returncode == 130 and time.monotonic() - asked < 5.0
    partial = rsc.load("run.h5")
    rows = len(partial.time)
    assert partial.status == "interrupted" and 0 < rows < len(long_run[1].time)
    assert np.array_equal(partial.rotor, long_run[1].rotor[:rows])
    again = rsc.simulate(long_run[0], path="run.h5", resume=True)
    assert same(again, long_run[1]) and again.status == "finished"


def test_a_finished_run_is_not_run_again(scene_file, long_run, monkeypatch):
    long_run[1].save("run.h5")
    monkeypatch.setattr("rsc.simulation.run.march", None)
    assert main(["run", "long.toml", "-o", "run.h5", "--resume"]) == 0


def test_another_scene_is_refused_and_nothing_lost(scene_file, long_run, capsys):
    long_run[1].save("run.h5")
    scene_file.write_text(long_run[0].with_values({"contact.friction": 0.06}).to_toml())
    assert main(["run", "long.toml", "-o", "run.h5", "--resume"]) == 2
    error = capsys.readouterr().err
    assert "contact.friction = 0.06: must be 0.05" in error and error.count("\n") == 1
    assert same(rsc.load("run.h5"), long_run[1])


@pytest.mark.parametrize("name", ["run.h5.left", "run.h5.part"])
def test_samples_of_a_killed_run_are_not_replaced_by_a_new_one(name, scene_file, tmp_path, long_run, capsys):
    scene = long_run[0].with_values({"drive.duration": 1.0})
    scene_file.write_text(scene.to_toml())
    rsc.simulate(scene, path="run.h5")
    os.rename("run.h5", name)
    before = (tmp_path / name).read_bytes()
    assert main(["run", "long.toml", "-o", "run.h5"]) == 4
    error = capsys.readouterr().err
    assert f"{name} holds 2001 samples of a killed run: go on with --resume" in error and error.count("error: ") == 1
    assert (tmp_path / name).read_bytes() == before and sorted(os.listdir()) == ["long.toml", name]
    assert main(["run", "long.toml", "-o", "run.h5", "--force"]) == 0
    assert sorted(os.listdir()) == ["long.toml", "run.h5"]


def test_a_part_that_cannot_be_read_is_replaced_and_that_is_said(scene_file, tmp_path, long_run, capsys):
    scene = long_run[0].with_values({"drive.duration": 4.0})
    scene_file.write_text(scene.to_toml())
    rsc.simulate(scene).save("run.h5.part")
    part = tmp_path / "run.h5.part"
    part.write_bytes(part.read_bytes()[:-50_000])
    assert main(["run", "long.toml", "-o", "run.h5"]) == 0
    told = "run.h5.part: what a killed run left there cannot be continued, and this run takes its place"
    assert told in capsys.readouterr().err


@pytest.mark.parametrize("content", [b"", bytes(40_000), b"\x89HDF\r\n\x1a\n" + bytes(30_000)])
def test_a_run_killed_before_its_first_checkpoint_begins_anew_and_says_so(scene_file, tmp_path, long_run, content, capsys):
    scene = long_run[0].with_values({"drive.duration": 1.0})
    scene_file.write_text(scene.to_toml())
    (tmp_path / "run.h5.part").write_bytes(content)
    assert main(["run", "long.toml", "-o", "run.h5", "--resume"]) == 0
    assert "the run was killed before its first checkpoint, and starts again" in capsys.readouterr().err
    assert same(rsc.load("run.h5"), rsc.simulate(scene)) and sorted(os.listdir()) == ["long.toml", "run.h5"]


def test_an_interrupted_result_goes_on_also_where_its_resumed_run_was_killed_at_once(scene_file, tmp_path, long_run):
    scene, signals = long_run[0].with_values({"drive.duration": 100.0}), []

    def stop(text):
        signals.append(text)
        if len(signals) == 1:
            signal.raise_signal(signal.SIGINT)

    def interrupting(writer, *parts, append=ResultWriter.append):
        append(writer, *parts)
        if writer._rows > 5000:
            stop("")

    with pytest.MonkeyPatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(ResultWriter, "append", interrupting)
        rsc.simulate(scene, path="run.h5")
    (tmp_path / "run.h5.part").write_bytes(b"")
    assert rsc.load("run.h5").status == "interrupted"
    assert same(rsc.simulate(scene, path="run.h5", resume=True), rsc.simulate(scene))


def test_a_part_whose_last_row_of_blocks_was_never_written_goes_on(scene_file, tmp_path, long_run):
    """Memory that is missing between an array's growth and its rows leaves that (tools/faults.py --memory)."""
    scene = long_run[0].with_values({"drive.duration": 100.0})
    rows = []

    def failing(writer, name, values, put=ResultWriter._put):
        if name == BLOCKS and len(rows) == 2:
            data = writer._file[name]
            data.resize(data.shape[0] + 1, axis=0)
            raise MemoryError
        if name == BLOCKS and len(values):
            rows.append(name)
        put(writer, name, values)

    with pytest.MonkeyPatch.context() as patch, pytest.raises(MemoryError):
        patch.setattr(ResultWriter, "_put", failing)
        rsc.simulate(scene, path="run.h5")
    with h5py.File(tmp_path / "run.h5.part") as file:
        assert file[BLOCKS][-1, 0] == -1 and len(file[BLOCKS]) == 3
    assert same(rsc.simulate(scene, path="run.h5", resume=True), rsc.simulate(scene))


def test_a_part_whose_facts_of_stretches_are_torn_begins_anew_and_says_so(scene_file, tmp_path, long_run):
    """A write that the machine did not end, over rows that were whole (tools/faults.py)."""
    scene, told = long_run[0].with_values({"drive.duration": 100.0}), []

    def killed(writer, *parts, append=ResultWriter.append):
        append(writer, *parts)
        if len(writer._file[STRETCHES]) > 3:
            raise OSError("gone")

    with pytest.MonkeyPatch.context() as patch, pytest.raises(OSError, match="gone"):
        patch.setattr(ResultWriter, "append", killed)
        rsc.simulate(scene, path="run.h5")
    with h5py.File(tmp_path / "run.h5.part") as file:
        place = file[STRETCHES].id.get_chunk_info(0)
    with open(tmp_path / "run.h5.part", "r+b") as file:
        file.seek(place.byte_offset)
        file.write(bytes(50))
    assert same(rsc.simulate(scene, path="run.h5", resume=True, note=told.append), rsc.simulate(scene))
    assert [line for line in told if line.endswith("is damaged, and the run starts again")]
    assert [file.name for file in tmp_path.iterdir() if "run.h5" in file.name] == ["run.h5"]


def test_what_somebody_puts_in_the_place_of_a_result_while_it_is_made_stays(scene_file, tmp_path, long_run):
    scene, finish = long_run[0].with_values({"drive.duration": 1.0}), ResultWriter.finish

    def late(writer, *parts):
        (tmp_path / "run.h5").write_bytes(b"mine")
        finish(writer, *parts)

    with pytest.MonkeyPatch.context() as patch, pytest.raises(rsc.DataError, match=r"the whole run is in run\.h5\.part"):
        patch.setattr(ResultWriter, "finish", late)
        rsc.simulate(scene, path="run.h5")
    assert (tmp_path / "run.h5").read_bytes() == b"mine"
    (tmp_path / "run.h5.part").rename("kept.h5")
    assert same(rsc.load("kept.h5"), rsc.simulate(scene))


def test_nothing_to_resume_is_refused(scene_file, capsys):
    assert main(["run", "long.toml", "-o", "run.h5", "--resume"]) == 4
    assert "does not exist" in capsys.readouterr().err


def test_a_result_of_a_method_that_is_gone_is_read_but_not_made_again(tmp_path):
    result, path = rsc.simulate(reference_scene("bouncing").with_values({"drive.duration": 1.0})), tmp_path / "old.h5"
    old = replace(result.scene, solver=replace(result.scene.solver, method="verner76"))
    replace(result, scene=old, summary=replace(result.summary, status=Status.INTERRUPTED)).save(path)
    assert same(rsc.load(path), result) and rsc.load(path).scene == old
    for scene in (old, result.scene):
        with pytest.raises(rsc.DataError, match="made by verner76, a method that is gone"):
            rsc.simulate(scene, path=path, resume=True, bitwise=False)
    with pytest.raises(rsc.SolverError, match="'verner76' no longer exists; use one of rk45, taylor8"):
        rsc.simulate(rsc.load(path).scene)


@pytest.mark.parametrize(("name", "size"), [("real", 11), ("x", 6)])
def test_a_checkpoint_of_other_numbers_is_not_continued(name, size):
    scene = reference_scene("bouncing")
    checkpoint = run_of(scene).checkpoint() | {name: np.zeros(size)}
    with pytest.raises(rsc.SolverError, match="version with a different state"):
        Run.resumed(scene, checkpoint)


def test_the_second_of_two_runs_on_one_output_is_refused(scene_file, tmp_path, long_run, capsys):
    process = started()
    wait_for_samples(process, tmp_path / "run.h5.part", 30_000)
    for more in ([], ["--resume"]):
        assert main(["run", "long.toml", "-o", "run.h5", *more]) == 4
        assert "another run" in capsys.readouterr().err
    process.communicate(timeout=60.0)
    assert process.returncode == 0 and same(rsc.load("run.h5"), long_run[1])


@pytest.mark.parametrize("limit", [1, 4_000_000])  # bytes: before, and behind, a first block
def test_a_full_disk_ends_with_exit_code_4_and_keeps_what_was_written(scene_file, tmp_path, long_run, limit):
    """A limit on the file's size stands for a full disk: the write fails in the same place."""

    def limited():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    process = started(preexec_fn=limited)
    _, error = process.communicate(timeout=60.0)
    assert process.returncode == 4, error
    assert "error: run.h5: cannot be written" in error
    if limit > 1:
        again = rsc.simulate(long_run[0], path="run.h5", resume=True)
        assert same(again, long_run[1])


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    path = tmp_path_factory.mktemp("small") / "run.h5"
    result = rsc.simulate(rsc.Scene.from_dict(SCENES["chains"]), path=path)
    return path.read_bytes(), {name: getattr(result, name) for name in ARRAYS}, result.summary, result.scene


def read_all(path):
    """Everything of a result, or None when it is refused."""
    try:
        result = rsc.load(path)
        return {name: getattr(result, name) for name in ARRAYS}, result.summary, result.scene
    except (rsc.DataError, rsc.SceneError) as error:
        assert "\n" not in str(error)
        return None


def check_never_wrong(found, small):
    if found is not None:
        assert all(np.array_equal(found[0][name], small[1][name]) for name in ARRAYS) and found[1:] == small[2:]
    return found is None


def test_truncated_files_are_refused(small, tmp_path):
    content = small[0]
    lengths = {1, 2, len(content) - 1, len(content) - 2} | set(np.linspace(0, len(content) - 1, 196).astype(int).tolist())
    for length in lengths:
        (tmp_path / "x.h5").write_bytes(content[:length])
        assert read_all(tmp_path / "x.h5") is None


def test_flipped_bits_never_give_a_wrong_value(small, tmp_path):
    """Most flips are noticed by a checksum; one in unused space changes nothing. No flip changes what is read."""
    content, bits, refused = small[0], random.Random(11), 0
    for _ in range(100):
        damaged = bytearray(content)
        place = bits.randrange(len(content))
        damaged[place] ^= 1 << bits.randrange(8)
        (tmp_path / "x.h5").write_bytes(damaged)
        refused += check_never_wrong(read_all(tmp_path / "x.h5"), small)
    assert refused > 50


@pytest.mark.parametrize("part", [b"friction = 0.2", b"duration = 0.4", b"finished", b"python 3", b"Laval"])
def test_a_flipped_bit_in_a_text_is_noticed(small, tmp_path, part):
    """HDF5 keeps texts of any length without a checksum of its own."""
    damaged = bytearray(small[0])
    damaged[small[0].index(part) + len(part) - 1] ^= 1
    (tmp_path / "x.h5").write_bytes(damaged)
    assert read_all(tmp_path / "x.h5") is None


def test_a_damaged_heap_is_not_searched(small, tmp_path):
    """Found by the fuzz: HDF5 went for ever round an object of size 0 in the heap of the texts of any length, of which there are
    none now but those that name the axes."""
    damaged, heaps, place = bytearray(small[0]), 0, small[0].find(b"GCOL")
    while place >= 0:
        damaged[place + 16 : place + 4096] = bytes(4080)  # all objects of size 0
        heaps, place = heaps + 1, small[0].find(b"GCOL", place + 4)
    (tmp_path / "x.h5").write_bytes(damaged)
    assert heaps
    check_never_wrong(read_all(tmp_path / "x.h5"), small)  # refused, or read without what is damaged


def test_a_checkpoint_of_zeros_is_not_resumed(long_run, tmp_path):
    """Zeros pass HDF5's sums as well."""
    scene = long_run[0].with_values({"drive.duration": 20.0})
    whole = rsc.simulate(scene, path=tmp_path / "x.h5")
    content = bytearray((tmp_path / "x.h5").read_bytes())
    with h5py.File(tmp_path / "x.h5") as file:
        chunk = file["checkpoint/x"].id.get_chunk_info(0)
    content[chunk.byte_offset : chunk.byte_offset + chunk.size] = bytes(chunk.size)
    (tmp_path / "x.h5").write_bytes(content)
    with pytest.raises(rsc.DataError, match="checkpoint 1 is damaged"):
        rsc.study.run.verify.verify(tmp_path / "x.h5", 1)
    assert same(rsc.load(tmp_path / "x.h5"), whole)
    (tmp_path / "x.h5").rename(tmp_path / "x.h5.part")
    # but the one at the start, where the rotor is at rest
    assert same(rsc.simulate(scene, path=tmp_path / "x.h5", resume=True), whole)


@pytest.mark.parametrize("damage", [b"\0", b"\xff"])
def test_zeros_for_ones_and_a_chunk_of_nothing_are_noticed(small, tmp_path, damage):
    """Both pass HDF5's Fletcher sums: 16 bits all flipped, and a chunk whose place on the disk reads as zeros, sum included."""
    (tmp_path / "x.h5").write_bytes(small[0])
    with h5py.File(tmp_path / "x.h5") as file:
        chunk = file["normal_force"].id.get_chunk_info(0)
        values = file["normal_force"][...].view("u2")
    content = bytearray(small[0])
    if damage == b"\0":
        content[chunk.byte_offset : chunk.byte_offset + chunk.size] = bytes(chunk.size)
    else:
        place = chunk.byte_offset + 2 * int(np.flatnonzero(values == 0)[5])
        content[place : place + 2] = b"\xff\xff"
    (tmp_path / "x.h5").write_bytes(content)
    with h5py.File(tmp_path / "x.h5") as file:
        assert not np.array_equal(file["normal_force"][...].view("u2"), values)  # HDF5 says nothing
    with pytest.raises(rsc.DataError, match="normal_force is damaged between samples 0 and"):
        _ = rsc.load(tmp_path / "x.h5").normal_force
