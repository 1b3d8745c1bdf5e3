"""The command line as a user meets it: exit codes, what is printed, what is written."""

import argparse
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rsc.cli import main
from rsc.cli.common import names_of
from systems import REFERENCE

SCENE = """
title = "short"
[rotor]
model = "laval"
mass = 1.0
frequency = 30.0
damping_ratio = 0.02
eccentricity = "0.05 mm"
[stator]
model = "laval"
mass = 0.25
frequency = 150.0
damping_ratio = 0.1
[contact]
gap = "1 mm"
friction = 0.2
stiffness = 3.55e6
damping_ratio = 0.05
[drive]
speed = [30.0, 60.0]
duration = "4 s"
[start]
whirl = "backward"
"""


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "short.toml"
    path.write_text(SCENE)
    return path


def test_version_tells_what_a_run_made_now_would_keep(scene, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    told = capsys.readouterr().out.strip()
    assert ended.value.code == 0 and main(["run", scene.name]) == 0 and main(["info", "short.h5"]) == 0
    assert f"made with {told}" in capsys.readouterr().out


@pytest.mark.versions
def test_check_prints_the_answer_and_writes_result_and_report(scene, capsys):
    assert main(["check", str(scene)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("verdict:") and any(line.startswith("check:") for line in lines)
    assert "predicted whirls" not in lines and max(map(len, lines[:-1])) <= 100
    folder = Path("out/short")
    assert {path.name for path in folder.iterdir()} == {"result.h5", "report.json", "report.html"}
    assert main(["check", str(scene), "--verbose"]) == 0
    assert "predicted whirls" in capsys.readouterr().out.splitlines()
    report = json.loads((folder / "report.json").read_text())
    assert {row["verdict"] for row in report["rows"] if row["quantity"] == "whirl frequency"} == {"agrees"}


@pytest.mark.versions
def test_pictures_of_results_with_one_name_do_not_replace_each_other():
    names = names_of(["a/run/x.h5", "b/run/x.h5", "b/run/x_2.h5", "a/run/x.h5", "run_x.h5"])
    assert names == ["run_x", "run_x_2", "run_x_2_2", "run_x_3", "_run_x"]


def test_run_info_plot_and_predict(scene, capsys):
    assert main(["run", str(scene), "-o", "run.h5"]) == 0
    assert main(["info", "run.h5", "--json"]) == 0
    info = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert info["summary"]["status"] == "finished" and info["scene"]["rotor"]["mass"] == 1.0
    assert main(["plot", "run.h5", "-o", "pictures"]) == 0
    assert Path("pictures/campbell.png").stat().st_size > 10_000
    capsys.readouterr()
    assert main(["predict", str(scene), "--speed", "50", "--json"]) == 0
    whirls = json.loads(capsys.readouterr().out)[0]
    assert any(abs(w["frequency"] + 60.66) < 0.01 and w["stable"] for w in whirls)


def test_predict_tells_branches_ends_and_delayed_jump_and_draws_the_map(tmp_path, capsys):
    scene = str(REFERENCE / "gyroscopic_transition.toml")
    assert main(["predict", scene, "-o", str(tmp_path / "map.png")]) == 0
    text = capsys.readouterr().out
    assert "stable below 68.6021 Hz (flutter, Hopf)" in text and "takes over at" in text
    assert (tmp_path / "map.png").stat().st_size > 10_000
    assert main(["predict", scene, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["delays"]["A"]["crossing"] == pytest.approx(68.6, abs=0.1)
    assert {b["label"] for b in found["branches"]} == set("ABCDE")


def test_new_scenes_can_be_checked(tmp_path, capsys):
    from rsc.scene.files.templates import MODELS

    for model in MODELS:
        assert main(["new", model]) == 0
        path = tmp_path / f"{model}.toml"
        path.write_text(capsys.readouterr().out)
        assert main(["predict", str(path)]) == 0
        assert "no whirl is predicted" not in capsys.readouterr().out


def test_bad_scene_is_refused_in_one_line_and_nothing_is_written(scene, capsys):
    scene.write_text(SCENE.replace("friction = 0.2", "frictoin = 0.2"))
    before = sorted(scene.parent.iterdir())
    assert main(["check", str(scene)]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and error.count("\n") == 1
    assert "contact.frictoin" in error and "friction" in error
    assert sorted(scene.parent.iterdir()) == before


def test_whirl_that_does_not_exist_is_refused(scene, capsys):
    scene.write_text(SCENE.replace("friction = 0.2", "friction = 0.001"))
    assert main(["run", str(scene), "-o", "run.h5"]) == 2
    assert "start.whirl" in capsys.readouterr().err
    assert not Path("run.h5").exists() and not Path("run.h5.part").exists()


def test_diverging_run_ends_with_exit_code_3_and_keeps_its_result(scene, capsys):
    text = SCENE.replace("friction = 0.2", "friction = 0.5").replace('model = "laval"\nmass = 0.25', 'model = "rigid"')
    text = text.replace("frequency = 150.0\ndamping_ratio = 0.1", "").replace('duration = "4 s"', 'duration = "400 s"')
    text = text.replace('whirl = "backward"', "rotor = [[9e-4, 0.0]]\nrotor_velocity = [[0.3, -0.3]]")
    scene.write_text(text)
    started = time.perf_counter()
    assert main(["run", str(scene), "-o", "run.h5"]) == 3
    assert "sliding" in capsys.readouterr().err
    assert main(["info", "run.h5"]) == 0
    assert "diverged" in capsys.readouterr().out
    assert time.perf_counter() - started < 60.0  # compilation included; the run itself takes well under a second


def test_unreadable_result_ends_with_exit_code_4(tmp_path, capsys):
    (tmp_path / "x.h5").write_text("nothing")
    assert main(["info", str(tmp_path / "x.h5")]) == 4
    assert capsys.readouterr().err.startswith("error: ")


def test_output_folder_that_cannot_be_made_ends_with_exit_code_4(scene, capsys):
    assert main(["check", str(scene), "-o", str(scene / "inside")]) == 4
    assert "cannot be written" in capsys.readouterr().err


def test_ctrl_c_keeps_a_readable_partial_result(scene, capsys):
    scene.write_text(SCENE.replace('duration = "4 s"', 'duration = "100000 s"'))
    process = subprocess.Popen([sys.executable, "-m", "rsc", "run", str(scene), "-o", "run.h5"], stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 90.0
    while not (Path("run.h5.part").exists() and Path("run.h5.part").stat().st_size > 100_000):
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=20.0) == 130
    assert main(["info", "run.h5"]) == 0
    assert "interrupted" in capsys.readouterr().out


def test_options_with_units_are_read_by_the_rule_of_scenes():
    from rsc.cli.common import in_hertz, in_si

    assert in_si("impulse")("2 lbf s") == pytest.approx(2 * 0.45359237 * 9.80665) and in_si("impulse")("0.5") == 0.5
    assert in_hertz("3000 rpm") == 50.0
    for text in ("3 mm", "3,5 N s", "1/2"):
        with pytest.raises(argparse.ArgumentTypeError, match="must be a number in N s"):
            in_si("impulse")(text)


def test_what_few_scenes_need_of_scipy_is_not_loaded_at_the_start_of_a_check():
    """A third of a second of processor time each, of some seconds."""
    code = (
        "import sys, rsc.cli.check, rsc.study.report.check, rsc.show.page; "
        "assert not {'scipy.optimize', 'scipy.interpolate', 'scipy.integrate', 'scipy.signal'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
