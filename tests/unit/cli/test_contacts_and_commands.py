"""The table of commands in docs/users/contacts.md is true: every command, at one to three contacts, of two bodies and of one."""

import shlex
from pathlib import Path

import numpy as np
import pytest

import rsc
from rsc.cli import COMMANDS, main
from tiers import nightly

PAGE = Path(__file__).parents[3] / "docs" / "users" / "contacts.md"
COLUMNS = {"1": (1, False), "2": (2, False), "3": (3, False), "one body": (2, True)}
ALONE = ("mu_min", "jump")  # of one contact: in the column of one body the scene has one
SIMULATING = ("run", "verify", "info", "report", "plot", "check", "motions", "impact", "remedy", "run,motions")


def rows():
    """(command, {column: cell}, what is not computed) of the table."""
    lines = PAGE.read_text().splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("| command | 1 |"))
    made = []
    for line in lines[head + 2 :]:
        if not line.startswith("|"):
            break
        command, *cells, missing = (cell.strip() for cell in line.strip("|").split(" |"))
        made.append((command.strip(" `"), dict(zip(COLUMNS, cells, strict=True)), missing))
    return made


ROWS = rows()
CASES = [
    (nightly if column in ("3", "one body") and cells[column] == "yes" else pytest.param)(command, column)
    for command, cells, _ in ROWS
    for column in COLUMNS
]


def chain(mass, stiffness, ground):
    """Mass and stiffness matrices of three equal masses, the outer ones on springs to the ground."""
    ends = np.diag([ground, 0.0, ground])
    return mass * np.eye(3), stiffness * np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]]) + ends


def scene_of(n, one_body):
    """A shaft of three masses in a casing of three, with n contacts between them; in one body or in two."""
    (m, k), (m_s, k_s) = chain(4.0, 1.2e6, 4e5), chain(1.0, 4e6, 2e6)
    contacts = []
    for i, name in ((1, "seal"), (2, "bush"), (0, "ring"))[:n]:
        at = {"rotor_coordinate": [i, i + 3]} if one_body else {"rotor_coordinate": i, "stator_coordinate": i}
        laws = {"gap": 2e-4, "friction": 0.2, "stiffness": 5e7, "damping_ratio": 0.05, "diameter": 0.1}
        contacts.append(laws | at | ({"name": name} if n > 1 else {}))
    none = np.zeros((3, 3))
    mass, stiffness = (np.block([[m, none], [none, m_s]]), np.block([[k, none], [none, k_s]])) if one_body else (m, k)
    rotor = {"model": "matrices", "mass": mass.tolist(), "stiffness": stiffness.tolist(), "damping": (2e-4 * stiffness).tolist()}
    rotor["eccentricity"] = [[5e-6, 0.0]] * 3 + [[0.0, 0.0]] * (len(mass) - 3)
    stator = {"model": "matrices", "mass": m_s.tolist(), "stiffness": k_s.tolist(), "damping": (1e-4 * k_s).tolist()}
    bodies = {"rotor": rotor} if one_body else {"rotor": rotor, "stator": stator}
    return rsc.Scene.from_dict(bodies | {
        "contact": contacts if n > 1 else contacts[0], "drive": {"speed": [30.0, 40.0], "duration": 0.3},
        "limits": {"minimum": 30.0, "maximum_continuous": 40.0},
    })  # fmt: skip


def words(command, folder):
    """The arguments of a command of the table."""
    places = {"SCENE": folder / "scene.toml", "RESULT": folder / "run.h5", "MAP": folder / "map.png"}
    own = [str(places.get(word, word)) for word in shlex.split(command)[1:]]
    if own[0] == "run":
        return own
    output = {"report": "pages", "check": "checked", "plot": "pictures", "sweep": "store"}.get(own[0])
    return [*own, "-o", str(folder / output)] if output else own


def simulates(command):
    kinds = set(command.replace(",", " ").split())
    return bool(kinds & set(SIMULATING))


def one_case(command, column, folder, capsys):
    n, one_body = COLUMNS[column]
    if one_body and command.split()[-1] in ALONE:
        n = 1
    (folder / "scene.toml").write_text(scene_of(n, one_body).to_toml())
    if "RESULT" in command and not command.startswith("rsc run"):
        assert main(["run", str(folder / "scene.toml"), "-o", str(folder / "run.h5")]) == 0
    capsys.readouterr()
    ended = main(words(command, folder))
    told = capsys.readouterr()
    (cells,) = (cells for own, cells, _ in ROWS if own == command)
    if cells[column] == "yes":
        assert ended == 0 and told.out.strip(), told.err
    else:
        assert cells[column] == "no" and ended == 2
        assert told.err.strip().splitlines()[-1].startswith("error: ")
    if n > 1 and ended == 0 and command == "rsc predict SCENE --speed 40":
        assert "forward rubs, whirls that roll" in told.out
    if command.endswith("MAP"):
        assert (folder / "map.png").stat().st_size > 10_000


@pytest.mark.parametrize(("command", "column"), [case for case in CASES if not simulates(case.values[0])])
def test_what_is_predicted(command, column, tmp_path, capsys):
    one_case(command, column, tmp_path, capsys)


@pytest.mark.nightly
@pytest.mark.parametrize(("command", "column"), [case for case in CASES if simulates(case.values[0])])
def test_what_is_simulated(command, column, tmp_path, capsys):
    one_case(command, column, tmp_path, capsys)


def test_the_table_has_every_command_that_takes_a_scene_or_a_result():
    known = {command.split()[1] for command, _, _ in ROWS}
    others = {"fit", "compare", "new", "import_model", "completion", "explore"}  # with a measured run, without a scene, or a page
    assert known == {module.__name__.rsplit(".", 1)[1] for module in COMMANDS} - others | {"info", "verify"}
