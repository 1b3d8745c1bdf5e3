"""A measured run beside a scene: what is told of one whose truth is known, and what is not told."""

import json
import re
from functools import cache

import numpy as np
import pytest

import rsc
from probes import pulses_of, turns_of, written
from rsc.cli import main
from rsc.measure.kinds import ProbeKind
from rsc.measured.virtual import write_measured
from rsc.show.page import page, write_page
from rsc.show.words.answer import answer

PUMP = {
    "title": "pump",
    "rotor": {"model": "laval", "mass": 12.0, "frequency": 43.3, "damping_ratio": 0.02, "eccentricity": 2e-5},
    "stator": {"model": "laval", "mass": 3.0, "frequency": 160.0, "damping_ratio": 0.1},
    "contact": {"gap": 2.5e-4, "friction": 0.2, "stiffness": 5e7, "damping_ratio": 0.05},
    "drive": {"speed": [40.0, 48.0], "duration": 4.0},
    "start": {"whirl": "backward"},
    "output": {"rate": 4000.0},
}
RUBS = PUMP | {
    "rotor": PUMP["rotor"] | {"eccentricity": 8e-5}, "contact": PUMP["contact"] | {"friction": 0.02},
    "drive": {"speed": [32.0, 48.0], "duration": 5.0}, "start": {"rest": True},
}  # fmt: skip


@cache
def run_of(name):
    return rsc.simulate(rsc.Scene.from_dict({"pump": PUMP, "rubs": RUBS}[name]))


@pytest.fixture
def probes(tmp_path):
    return write_measured(run_of("pump"), tmp_path / "probes.toml", noise=2e-6)


def told(report):
    lines = {}
    for topic, text in answer(report):
        lines.setdefault(topic, []).append(text)
    return lines


def test_the_whirl_of_a_run_is_found_as_without_noise(probes):
    scene, run = rsc.Scene.from_dict(PUMP), run_of("pump")
    report = rsc.compare(scene, rsc.read_measured(probes))
    clean = rsc.spectral_peaks(run, "negative", count=1, window=report.fall.window)
    assert set(report.features.kind) == {ProbeKind.WHIRL} and len(report.windows) == len(clean.time)
    assert np.mean(np.abs(report.features.frequency - clean.frequency[:, 0]) < 0.05) > 0.95
    assert np.mean(np.abs(report.features.amplitude / clean.amplitude[:, 0] - 1.0) < 0.005) > 0.95
    np.testing.assert_allclose(report.fall.speed, clean.speed, atol=0.02)
    assert "windows with a backward line, amplitude" in report.agreement
    assert {window.frequency.verdict for window in report.windows} == {"agrees"}
    lines = told(report)
    assert lines["model"][0].startswith("its whirl A is the measured one")
    whirl = next(whirl for whirl in rsc.predict(scene, 44.0) if whirl.stable)
    assert lines["force"][0].endswith(f"presses with {whirl.normal_force:.3g} N")
    assert all(root.is_that_whirl and not root.brings for root in report.nearest)


def test_forces_and_contact_are_not_told(probes, tmp_path):
    report = rsc.compare(rsc.Scene.from_dict(PUMP), rsc.read_measured(probes))
    assert report.strip is None and report.stretches is None and report.stator_fall is None
    assert np.isnan(report.features.force).all() and "neither contact nor force" in told(report)["not told"][0]
    text = page(report)
    for words in ("Force and friction", "Energy", "What can last", "simulated"):
        assert words not in text.partition("<script")[0]
    for words in ("Measured and predicted", "Polar", "measured, largest"):
        assert words in text
    assert len(text.encode()) < 1.2e6


@pytest.mark.parametrize("friction, found", [(0.1, 0.18), (0.01, 0.18)])
def test_a_model_without_the_whirl_is_told_so_with_what_would_do(probes, friction, found):
    scene = rsc.Scene.from_dict(PUMP).with_values({"contact.friction": friction})
    report = rsc.compare(scene, rsc.read_measured(probes))
    lines = told(report)
    assert "is the measured one" not in lines["model"][0] and lines["force"][0].startswith("unknown: ")
    assert not any(root.is_that_whirl for root in report.nearest)
    if friction == 0.01:  # 0.18 is further than a factor of 4
        assert "contact.friction" not in lines["would do"][0]
        return
    (friction_does, *_) = next(root.brings for root in report.nearest if root.brings)
    assert friction_does.name == "contact.friction" and friction_does.needed == pytest.approx(found, rel=0.02)
    whirls = rsc.predict(scene.with_values({"contact.friction": friction_does.needed}), report.nearest[2].speed)
    assert min(abs(w.frequency / report.nearest[2].measured - 1.0) for w in whirls if w.stable) < 0.02


def test_a_whirl_of_the_model_that_is_unstable_is_named_with_its_growth(tmp_path):
    scene = rsc.Scene.from_dict(PUMP)
    unstable = next(whirl for whirl in rsc.predict(scene, 44.0) if whirl.frequency > -60.0 and not whirl.stable)
    time = np.arange(0.0, 4.0, 1.0 / 4000.0)
    motion = unstable.rotor_amplitude * np.exp(2j * np.pi * unstable.frequency * time)
    path = written(tmp_path, time, motion, pulses_of(turns_of(time, (40.0, 48.0))))
    report = rsc.compare(scene, rsc.read_measured(path))
    root = report.nearest[2]
    assert not root.stable and root.frequency == pytest.approx(unstable.frequency, rel=0.01)
    assert f"unstable (grows at {root.growth_rate:.3g} 1/s)" in told(report)["model"][0]
    assert told(report)["force"][0].startswith("unknown: ")
    assert all(window.branch for window in report.windows) and not report.result.warnings


def test_a_forward_rub_is_no_whirl_and_its_bode_is_that_of_the_run(tmp_path):
    run, scene = run_of("rubs"), rsc.Scene.from_dict(RUBS)
    report = rsc.compare(scene, rsc.read_measured(write_measured(run, tmp_path / "rub.toml", noise=2e-6)))
    assert set(report.features.kind) == {ProbeKind.WITH_SHAFT} and not report.nearest
    clean = rsc.check(scene)
    wanted = np.interp(report.fall.speed, clean.fall.speed, np.abs(clean.order))
    np.testing.assert_allclose(np.abs(report.order), wanted, rtol=0.02)
    assert "of a forward rub at" in told(report)["1X"][0] and told(report)["motion"][0].startswith("no backward whirl")
    assert {window.synchronous.by for window in report.windows} == {"without contact", "forward rub"}


def test_exchanged_probes_are_told_before_any_verdict(tmp_path):
    path = write_measured(run_of("rubs"), tmp_path / "rub.toml")
    path.write_text(path.read_text().replace('"X"', '"?"').replace('"Y"', '"X"').replace('"?"', '"Y"'))
    report = rsc.compare(rsc.Scene.from_dict(RUBS), rsc.read_measured(path))
    topic, text = answer(report)[0]
    assert topic == "signals" and "are the probes exchanged" in text and text == report.warnings[0]


def test_a_run_with_holes_is_compared_beside_them(probes):
    data = probes.with_suffix(".csv")
    head, *rows = data.read_text().splitlines()
    kept = [row for i, row in enumerate(rows) if not 6000 <= i < 6100]
    kept[9000] = ";".join([kept[9000].split(";")[0], "nan", *kept[9000].split(";")[2:]])
    kept.insert(3000, kept[2999])
    data.write_text("\n".join([head, *kept]) + "\n")
    report = rsc.compare(rsc.Scene.from_dict(PUMP), rsc.read_measured(probes))
    signals = " ".join(told(report)["signals"])
    for words in ("repeat the time", "samples are missing", "are no numbers"):
        assert words in signals
    holes = report.features.kind == ProbeKind.NOT_RESOLVED
    assert 0 < holes.sum() < 0.6 * len(holes) and set(report.features.why[holes]) == {"samples are missing"}
    assert {window.frequency.verdict for window, hole in zip(report.windows, holes, strict=True) if not hole} == {"agrees"}
    assert not re.search(r'[ "](nan|inf)[ "<]', page(report).partition("<script")[0])


def test_without_a_mark_a_constant_speed_is_one(tmp_path):
    steady = rsc.Scene.from_dict(PUMP | {"drive": {"speed": 45.0, "duration": 2.0}})
    path = write_measured(rsc.simulate(steady), tmp_path / "steady.toml", noise=1e-6)
    report = rsc.compare(steady, rsc.read_measured(path))
    assert len(set(report.fall.speed)) == 1 and report.fall.speed[0] == pytest.approx(45.0, abs=0.01)
    assert {window.frequency.verdict for window in report.windows} == {"agrees"}
    write_page(report, tmp_path / "steady.html")


def test_the_command_prints_the_answer_and_writes_the_page(probes, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pump.toml").write_text(rsc.Scene.from_dict(PUMP).to_toml())
    assert main(["compare", "pump.toml", "probes.toml"]) == 0
    assert "written: out/probes/comparison.html" in capsys.readouterr().out
    assert main(["compare", "probes.csv", "pump.toml", "-o", "page.html", "--verbose"]) == 0
    assert "measured and predicted" in capsys.readouterr().out and (tmp_path / "page.html").stat().st_size > 1e5
    assert main(["compare", "probes.toml", "pump.toml", "-o", "page.html", "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["nearest"] and content["summary"] is None and len(content["rows"]) % 3 == 0
    for arguments, code, told in (
        (["none.toml", "pump.toml"], 2, "none.toml"), (["pump.toml", "pump.toml"], 2, "neither has a table [measured]"),
        (["probes.toml", "probes.csv"], 2, "both are measured runs"),
        (["pump.toml", "probes.toml", "-o", "pump.toml"], 4, "pump.toml"),
    ):  # fmt: skip
        assert main(["compare", *arguments]) == code
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert told in line
