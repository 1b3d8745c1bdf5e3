"""`rsc sweep`: parts anywhere, exit codes, one line for what cannot be meant."""

import json
import os

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.study.sweep.dataset import load_dataset
from scenes import LAVAL, changed

GRID = ["--vary", "contact.friction=0.001,0.1,0.15", "--vary", "drive.speed=50:60:6"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = changed(LAVAL, drive={"duration": 0.2}, start={"whirl": "backward"})
    (tmp_path / "laval.toml").write_text(rsc.Scene.from_dict(scene).to_toml())
    return tmp_path


def test_a_sweep_is_stored_told_and_resumed(capsys):
    assert main(["sweep", "laval.toml", *GRID]) == 0
    told = capsys.readouterr()
    assert "18 cases: 18 finished" in told.out and "a whirl is predicted only in 12 cases" in told.out
    assert "18 cases in 3 parts" in told.err
    assert main(["sweep", "laval.toml", *GRID]) == 4
    assert "--resume" in capsys.readouterr().err
    assert main(["sweep", "laval.toml", *GRID, "--resume", "--compute", "predict,run"]) == 5
    told = capsys.readouterr()
    assert "12 finished, 6 impossible" in told.out.replace("6 impossible, 12 finished", "12 finished, 6 impossible")
    assert "6 x such as start.whirl = 'backward': must be a stable backward whirl" in told.err and told.err.count("\n") < 5
    data = load_dataset("out/laval-sweep/sweep.nc")
    assert data.dims["drive.speed"] == 6 and np.isfinite(data["whirl_amplitude"][1:]).all()


def test_everything_is_told_as_json(capsys):
    def told(*words):
        code = main(["sweep", *words, "--json"])
        return code, json.loads(capsys.readouterr().out)

    code, ended = told("laval.toml", *GRID, "--compute", "predict,run")
    assert code == 5 and ended["cases"] == 18 and ended["dims"] == {"contact.friction": 3, "drive.speed": 6}
    assert ended["status"] == {"finished": 12, "impossible": 6} and ended["danger"] and "start.whirl" in ended["reasons"][0]
    data = load_dataset(ended["dataset"])
    assert sum(ended["danger"].values()) == data["status"].size and ended["store"] == "out/laval-sweep"
    assert told("plan", "laval.toml", *GRID, "-o", "store") == (0, {"store": "store", "parts": 3})
    assert main(["sweep", "run", "store", "--part", "1"]) == 0
    code, state = told("status", "store")
    assert (code, state["parts"], state["there"], state["missing"]) == (0, 3, 1, "0,2")
    code, part = told("collect", "store")
    assert code == 5 and part["status"]["missing"] > 0 and part["cases"] == 18
    code, scene = told("scene", "store", "17")
    assert code == 0 and rsc.Scene.from_dict(scene).drive.speed == (60.0, 60.0)


def test_parts_computed_anywhere_and_collected_are_the_same_sweep(capsys):
    assert main(["sweep", "plan", "laval.toml", *GRID, "-o", "store"]) == 0
    assert "3 parts: rsc sweep run store --part N" in capsys.readouterr().out
    assert main(["sweep", "run", "store", "--part", "2"]) == 0
    assert main(["sweep", "status", "store"]) == 0
    assert "1 of 3 parts are there; missing: 0-1" in capsys.readouterr().out
    assert main(["sweep", "collect", "store"]) == 5
    assert "16 missing, 2 finished" in capsys.readouterr().out
    assert main(["sweep", "run", "store", "--part", "0-2"]) == 0
    assert "part 2 is there" in capsys.readouterr().err
    assert main(["sweep", "collect", "store"]) == 0
    assert main(["sweep", "laval.toml", *GRID, "-o", "at once"]) == 0
    for name in sorted(os.listdir("store/parts")):
        with open(f"store/parts/{name}", "rb") as one, open(f"at once/parts/{name}", "rb") as other:
            assert one.read() == other.read()
    with open("store/sweep.nc", "rb") as one, open("at once/sweep.nc", "rb") as other:
        assert one.read() == other.read()


@pytest.mark.parametrize("name", ["store", "store/lock", "store/parts", "store/sweep.nc"])
def test_a_link_in_the_store_ends_with_exit_code_4_and_changes_nothing(name, capsys):
    os.mkdir("elsewhere")
    with open("precious", "w") as file:
        file.write("kept")
    if name != "store":
        os.mkdir("store")
    os.symlink(os.path.abspath("elsewhere" if name in ("store", "store/parts") else "precious"), name)
    assert main(["sweep", "laval.toml", *GRID, "-o", "store", "--threads", "1"]) == 4
    assert capsys.readouterr().err.splitlines()[-1].startswith("error: store")
    with open("precious") as file:
        assert file.read() == "kept" and os.listdir("elsewhere") == []


def test_a_pipe_as_lock_is_refused_and_not_waited_for(capsys):
    os.mkdir("store")
    os.mkfifo("store/lock")
    assert main(["sweep", "laval.toml", *GRID, "-o", "store"]) == 4
    assert capsys.readouterr().err.splitlines()[-1] == "error: store/lock: cannot be used as a lock (it is a pipe)"


def test_the_scene_of_a_case_can_be_printed_and_run(capsys):
    assert main(["sweep", "plan", "laval.toml", *GRID, "-o", "store"]) == 0
    capsys.readouterr()
    assert main(["sweep", "scene", "store", "7"]) == 0
    scene = rsc.Scene.from_toml(capsys.readouterr().out)
    assert scene.contact.friction == 0.1 and scene.drive.speed == (52.0, 52.0)


@pytest.mark.parametrize(
    ("words", "code", "part"),
    [
        (["laval.toml"], 2, "a sweep of 0 cases"),
        (["laval.toml", "--vary", "contact.friction"], 2, "--vary contact.friction: must be KEY=VALUES"),
        (["laval.toml", "--vary", "contact.fricton=1,2"], 2, 'did you mean "contact.friction"'),
        (["laval.toml", "--vary", "contact.friction=-1:1:3"], 2, "contact.friction = -1.0: must be a number >= 0 and <= 5"),
        (["laval.toml", "--vary", "contact.friction=0.1,0.2", "--vary", "contact.friction=0.1,0.2"], 2, "given once"),
        (["laval.toml", "--vary", "contact.friction=0:1:1000000000"], 2, "at most 10000000"),
        (["laval.toml", "--vary", "contact.friction=0:1:100000", "--vary", "drive.speed=1:9:100000"], 2, "--yes"),
        (["laval.toml", "--vary", "contact.friction=0:1:99999", "--vary", "drive.speed=1:9:999999", "--yes"], 2, "of memory"),
        (["laval.toml", *GRID, "--compute", "all"], 2, "predict, mu_min, jump, run, motions, check"),
        (["laval.toml", *GRID, "--threads", "-1"], 2, "threads = -1: must be"),
        (["laval.toml", *GRID, "--scheduler", "no scheduler"], 2, "no dask scheduler answers"),
        (["laval.toml", *GRID, "-o", "laval.toml"], 4, "must be a new or an empty folder"),
        (["laval.toml", *GRID, "-o", "map.nc"], 4, "map.nc: must be a folder, into which files are written: leave .nc out"),
        (["plan", "laval.toml", *GRID, "-o", "map.h5"], 4, "must be a folder"),
        (["laval.toml", *GRID, "-o", "."], 4, "must be a new or an empty folder"),
        (["laval.toml", *GRID, "--resume", "-o", "none"], 4, "holds no sweep to resume"),
        (["laval.toml", "--table", "none.csv"], 4, "no such file"),
        (["nothing", "laval.toml"], 2, "must be one scene, or one of plan, run, status, collect, scene"),
        (["status", "none"], 4, "is no store of a sweep"),
        (["collect", "none"], 4, "is no store of a sweep"),
        (["run", "none", "--part", "1"], 4, "is no store of a sweep"),
        (["scene", "none"], 2, "must be scene STORE N"),
    ],
)
def test_a_bad_sweep_is_refused_in_one_line_and_nothing_written(words, code, part, capsys, folder):
    before = sorted(os.listdir(folder))
    assert main(["sweep", *words]) == code
    told = capsys.readouterr().err
    last = told.strip().splitlines()[-1]
    assert last.startswith("error: ") and part in last and "Traceback" not in told
    assert sorted(os.listdir(folder)) == before


def test_numbers_of_parts_are_checked(capsys):
    assert main(["sweep", "plan", "laval.toml", *GRID, "-o", "store"]) == 0
    for numbers in ("3", "-1", "2-1", "x", "1-9"):
        assert main(["sweep", "run", "store", f"--part={numbers}"]) == 2
        assert "must be a number from 0 to 2, or A-B" in capsys.readouterr().err
    assert main(["sweep", "run", "store"]) == 2
