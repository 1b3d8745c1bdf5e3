"""Which cases a sweep has."""

import time

import numpy as np
import pytest
import scipy

import rsc
from rsc.study.sweep.vary import cases
from scenes import LAVAL

SCENE = rsc.Scene.from_dict(LAVAL, "laval.toml")


def test_a_grid_runs_over_every_combination():
    grid = cases(SCENE, {"contact.friction": "0.1:0.4:4", "drive.speed": "3000 rpm, 60 Hz"})
    assert grid.dims == {"contact.friction": 4, "drive.speed": 2} and len(grid) == 8
    assert grid.values(1, 4) == [(0.1, 60.0), (0.2, 50.0), (0.2, 60.0)]
    assert grid.axes[1].unit == "Hz"


def test_ranges_lists_and_words():
    assert cases(SCENE, {"contact.gap": "log:0.1 mm:10 mm:3"}).axes[0].values == (1e-4, 1e-3, 1e-2)
    assert cases(SCENE, {"contact.gap": "0.1:0.4 mm:4"}).axes[0].values == (1e-4, 2e-4, 3e-4, 4e-4)
    assert cases(SCENE, {"contact.gap": "0.1,0.4 mm"}).axes[0].values == (1e-4, 4e-4)
    assert cases(SCENE, {"solver.method": "rk45,taylor8"}).axes[0].values == ("rk45", "taylor8")
    assert cases(SCENE, {"solver.max_steps": "10:30:3"}).axes[0].values == (10, 20, 30)
    assert cases(SCENE, {"drive.speed": np.array([10.0, 20.0])}).values(0, 2) == [(10.0,), (20.0,)]


def test_flags_are_told_as_in_a_scene():
    (axis,) = rsc.cases(SCENE, {"start.allow_penetration": "false,true"}).axes
    assert axis.values == (False, True)


def test_a_finer_range_holds_the_values_of_a_coarser_one():
    coarse, fine = (cases(SCENE, {"contact.friction": f"0.05:0.4:{n}"}).axes[0].values for n in (8, 36))
    assert set(coarse) < set(fine)


def test_keys_go_side_by_side():
    pairs = cases(SCENE, {"drive.speed": [10, 20], "contact.gap": "1 mm, 2 mm"}, zipped=True)
    assert pairs.dims == {"zipped": 2} and pairs.values(0, 2) == [(10.0, 1e-3), (20.0, 2e-3)]
    with pytest.raises(rsc.SolverError, match=r"2 of drive.speed, 1 of contact.gap"):
        cases(SCENE, {"drive.speed": [10, 20], "contact.gap": "1 mm"}, zipped=True)


@pytest.mark.parametrize("how", ["random", "sobol"])
def test_samples_follow_their_distribution_and_seed(how):
    vary = {"contact.friction": "normal:0.2:0.02", "contact.gap": "uniform:0.5 mm:1 mm", "drive.speed": [40.0, 50.0]}
    drawn = cases(SCENE, vary, seed=3, **{how: 1024})
    assert drawn.dims == {"drive.speed": 2, "sample": 1024}
    friction, gap = (np.array(axis.values) for axis in drawn.axes[1:])
    # Kolmogorov-Smirnov at 1 %, an error of first kind that the fixed seed does not meet
    assert scipy.stats.kstest(friction, scipy.stats.norm(0.2, 0.02).cdf).statistic < 1.63 / 32
    assert scipy.stats.kstest(gap, scipy.stats.uniform(0.5e-3, 0.5e-3).cdf).statistic < 1.63 / 32
    assert abs(np.corrcoef(friction, gap)[0, 1]) < 0.1
    assert drawn == cases(SCENE, vary, seed=3, **{how: 1024}) != cases(SCENE, vary, seed=4, **{how: 1024})


def test_a_table_gives_the_cases(tmp_path):
    table = tmp_path / "cases.csv"
    table.write_text("contact.friction, contact.gap\n0.1,0.2 mm\n\n9,1000 um\n", encoding="utf-8-sig")
    from_table = cases(SCENE, table=table)
    assert from_table.dims == {"case": 2} and from_table.values(0, 2) == [(0.1, 2e-4), (9.0, 1e-3)]
    for text, message in (
        ("contact.friction\n0.1,0.2\n", "line 2 has 2 cells"),
        ("contact.friction\n0.1\n0,2 x\n", "line 3 has 2 cells"),
        ("contact.gap\n1 mm\n1 kg\n", "line 3: contact.gap = '1 kg'"),
        ("contact.gap\n1 mm\n0.2\n", "column contact.gap: must be numbers that all have a unit, like '1 mm'"),
        ("contact.gap\n", "0 cases"),
        ("contact.gap,contact.gap\n1,1\n", "different values"),
        ("contact.gab\n1\n", "contact.gap"),
    ):
        table.write_text(text)
        with pytest.raises((rsc.DataError, rsc.SceneError), match=message):
            cases(SCENE, table=table)
    with pytest.raises(rsc.DataError, match="no such file"):
        cases(SCENE, table=tmp_path / "none.csv")


@pytest.mark.parametrize(
    "text",
    ["contact.friction\n\"" + "x" * 200_000, "contact.friction\n\"0.1\n0.2\n", '"contact.friction', 'contact.friction\n"0.1"0\n',
     "contact.friction\n" + "1" * 200_000, "contact.friction\n0.1\r0.2\"\n0.1\n\"\"\"", '"' * 7, "\0" * 9],
    ids=["long quote", "open quote", "open head", "text behind a quote", "long cell", "odd", "quotes", "zeros"],
)  # fmt: skip
def test_a_table_that_is_no_csv_is_refused_in_one_line(text, tmp_path):
    table = tmp_path / "cases.csv"
    table.write_text(text)
    with pytest.raises((rsc.DataError, rsc.SceneError)) as refusal:
        cases(SCENE, table=table)
    assert "\n" not in str(refusal.value) and len(str(refusal.value)) < 700


def test_equal_cases_of_a_table_are_refused_at_the_first(tmp_path):
    table = tmp_path / "cases.csv"
    table.write_text("contact.friction,contact.gap\n" + "0.1,1 mm\n0.2,1 mm\n\n0.1,1000 um\n" * 300_000)
    began = time.process_time()
    with pytest.raises(rsc.DataError, match="line 5 is the case of line 2 again"):
        cases(SCENE, table=table)
    assert time.process_time() - began < 1.0


@pytest.mark.parametrize(
    ("vary", "options", "message"),
    [
        ({}, {}, "0 cases"),
        ({"contact.fricton": "1,2"}, {}, 'did you mean "contact.friction"'),
        ({"contact.friction": "0.1:0.1:5"}, {}, "step is 0"),
        ({"contact.friction": "0.1:0.2:0"}, {}, "0 cases"),
        ({"contact.friction": "0.1,0.1"}, {}, "different values"),
        ({"contact.friction": []}, {}, "0 cases"),
        ({"contact.friction": 0.1}, {}, "a sequence"),
        ({"contact.friction": "-1:1:4"}, {}, "contact.friction = -1.0: must be a number >= 0 and <= 5"),
        ({"contact.friction": "0.1:0.4"}, {}, "FROM:TO:NUMBER"),
        ({"contact.friction": "0:1:1e3"}, {}, "a whole number"),
        ({"contact.friction": "log:0:1:3"}, {}, "numbers > 0"),
        ({"contact.friction": "0:1:1000000000"}, {}, "at most 10000000"),
        ({"contact.friction": "0:1:100000", "drive.speed": "1:9:10000"}, {}, r"1000000000 cases: .* at most 10000000 \(--yes"),
        ({"contact.friction": "normal:0.2:0.02"}, {}, "--random N or --sobol N"),
        ({"contact.friction": "normal:0.2:-1"}, {"random": 4}, "deviation > 0"),
        ({"contact.friction": "uniform:0.2:0.1"}, {"random": 4}, "rises"),
        ({"contact.friction": "0.1,0.2"}, {"random": 4}, "no random values to sample"),
        ({"contact.friction": "normal:0.2:0.1"}, {"random": 4, "sobol": 4}, "exclude each other"),
        ({"contact.friction": "normal:0.2:0.1"}, {"random": -4}, "from 1 to"),
        ({"solver.method": "normal:1:2"}, {"random": 4}, "of the form normal"),
    ],
)
def test_cases_that_cannot_be_meant_are_refused_in_one_line(vary, options, message):
    with pytest.raises(rsc.RscError, match=message) as refusal:
        cases(SCENE, vary, **options)
    assert "\n" not in str(refusal.value)
