"""No command replaces a file that rsc did not write, or that somebody changed since: nothing is computed, nothing is written."""

import argparse
import io
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from rsc.cli import _parser, main
from rsc.files import mark
from rsc.files.output import FOREIGN

SCENE = Path(__file__).with_name("test_cli.py").read_text(encoding="utf-8").split('SCENE = """')[1].split('"""')[0]
ROSS = Path(__file__).parents[3] / "data" / "reference" / "machines" / "ross_coaxrotor.mat"
FE = ["import", "fe", "--mass", "M.npz", "--stiffness", "K.npz", "--coordinates", "t.csv", "--contact", "2"]
VARY = ["--vary", "contact.friction=0.1,0.2"]
# command, and the files that it writes
COMMANDS = {
    "predict png": (["predict", "s.toml", "-o", "map.png"], ["map.png"]),
    "predict svg": (["predict", "s.toml", "-o", "map.svg"], ["map.svg"]),
    "predict pdf": (["predict", "s.toml", "-o", "map.pdf"], ["map.pdf"]),
    "modes png": (["modes", "s.toml", "--speeds", "10:20:3", "-o", "modes.png"], ["modes.png"]),
    "modes csv": (["modes", "s.toml", "--speeds", "10:20:3", "-o", "modes.csv"], ["modes.csv"]),
    "motions": (["motions", "s.toml", "--speed", "50", "--starts", "1", "-o", "starts.png"], ["starts.png"]),
    "run": (
        ["run", "s.toml", "-o", "run.h5", "--as-measured", "bench.toml"],
        ["run.h5", "run.h5.part", "run.h5.left", "bench.toml", "bench.csv"],
    ),
    "check": (["check", "s.toml", "-o", "out"], ["out/result.h5", "out/report.html", "out/report.json", "out/result.h5.part"]),
    "report": (["report", "out/result.h5", "-o", "pages"], ["pages/report.html"]),
    "plot": (
        ["plot", "out/result.h5", "-o", "pictures", "--animate"],
        ["pictures/campbell.png", "pictures/orbit.png", "pictures/waterfall.png", "pictures/orbit.gif"],
    ),
    "sweep": (["sweep", "s.toml", *VARY, "-o", "sw", "--resume"], ["sw/sweep.nc"]),
    "sweep collect": (["sweep", "collect", "sw"], ["sw/sweep.nc"]),
    "plot of a sweep": (["plot", "sw/sweep.nc", "-o", "maps"], ["maps/curves.png"]),
    "report of a sweep": (["report", "sw/sweep.nc", "-o", "pages"], ["pages/report.html"]),
    "compare": (["compare", "probes.toml", "s.toml", "-o", "compared.html"], ["compared.html"]),
    "fit": (["fit", "probes.toml", "s.toml", "--free", "contact.friction", "-o", "fitted.toml"], ["fitted.toml"]),
    "import": ([*FE, "-o", "m.toml"], ["m.toml", "m.npz"]),
    "import npz": ([*FE, "-o", "n.npz"], ["n.npz"]),
    "import ross": (["import", "ross", "ross.mat", "-o", "r.toml", "--contact", "5"], ["r.toml", "r.npz"]),
    "new": (["new", "laval", "-o", "l.toml"], ["l.toml"]),
}
CASES = [(name, file) for name, (_, files) in COMMANDS.items() for file in files]


def writers(parser, words=()):
    """The words of every command that has an option for an output."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for word, own in action.choices.items():
                yield from writers(own, (*words, word))
        elif "--output" in action.option_strings:
            yield words


def test_every_command_that_writes_is_tried():
    tried = {tuple(command[: len(words)]) for command, _ in COMMANDS.values() for words in writers(_parser())}
    assert set(writers(_parser())) <= tried


def hdf5_of_another():
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        file.attrs["format"] = "rsc-like"
        file["mine"] = np.arange(3)
    return content.getvalue()


def archive_of_mine():
    content = io.BytesIO()
    np.savez(content, mine=np.arange(3))
    return content.getvalue()


# files of the user whose first bytes are those of rsc's
MINE = {
    ".png": b"\x89PNG\r\n\x1a\nmy holiday", ".svg": b"<?xml version='1.0'?><svg>mine</svg>", ".pdf": b"%PDF-1.4 my thesis",
    ".csv": b"t;X;Y;KPH\n0;-9.1;-8.9;0\n", ".toml": b"# Written by rsc: changed by me\n[measured]\n", ".gif": b"GIF89a my cat",
    ".html": b"<!DOCTYPE html><html>my page</html>", ".json": b'{"mine": 1}', ".h5": hdf5_of_another(), ".nc": hdf5_of_another(),
    ".npz": archive_of_mine(), ".part": b"half of a download", ".left": hdf5_of_another(),
}  # fmt: skip


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder with inputs, and with what the commands that compute little have written."""
    folder = tmp_path_factory.mktemp("whole")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Path("s.toml").write_text(SCENE.replace("4 s", "1 s"))
        stiffness = 1e6 * np.kron(np.diag([3.0, 4.0, 4.0, 3.0]) - np.diag([1.0] * 3, 1) - np.diag([1.0] * 3, -1), np.eye(2))
        np.savez("K.npz", K=stiffness)
        shutil.copy(ROSS, "ross.mat")
        np.savez("M.npz", M=10.0 * np.eye(8))
        Path("t.csv").write_text("node,direction\n" + "".join(f"{i},{d}\n" for i in (1, 2, 3, 4) for d in "xy"))
        assert main(["run", "s.toml", "-o", "once.h5", "--as-measured", "probes.toml"]) == 0
        assert main(["sweep", "s.toml", *VARY, "-o", "sw"]) == 0
        for name in (name for name in QUICK if name != "sweep"):
            assert main(COMMANDS[name][0]) == 0, name
    return folder


@pytest.fixture
def copied(whole, tmp_path, monkeypatch):
    shutil.copytree(whole, tmp_path / "own")
    monkeypatch.chdir(tmp_path / "own")
    return tmp_path / "own"


def content(folder):
    return {path.relative_to(folder): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def refused(command, file, folder, capsys):
    before = content(folder)
    capsys.readouterr()
    code = main(command)
    told = capsys.readouterr().err.strip().splitlines()
    assert code == 4 and len([line for line in told if line.startswith("error: ")]) == 1
    assert told[-1].startswith(f"error: {file}: cannot be written (") and FOREIGN in told[-1] and "--force" in told[-1]
    assert content(folder) == before


@pytest.mark.parametrize(("name", "file"), CASES, ids=[f"{name}: {file}" for name, file in CASES])
def test_a_file_of_the_user_is_never_replaced(name, file, copied, capsys):
    for old in (*COMMANDS[name][1], *(str(Path(f).with_name(mark.name_beside(Path(f).name))) for f in COMMANDS[name][1])):
        Path(old).unlink(missing_ok=True)
    Path(file).parent.mkdir(exist_ok=True)
    Path(file).write_bytes(MINE[Path(file).suffix])
    refused(COMMANDS[name][0], file, copied, capsys)


def changed(content):
    """The bytes of a file after a small change by somebody."""
    return content.replace(b"rsc", b"me ", 1) if content.count(b"rsc") else content[:100] + b"\0" + content[101:] + b"\n"


def edited_hdf5(file):
    with h5py.File(file, "r+") as own:
        own.attrs["remark"] = "the good one"


QUICK = ("predict png", "modes csv", "run", "check", "report", "plot", "plot of a sweep", "sweep", "import")
EDITED = [
    (name, file) for name in QUICK for file in COMMANDS[name][1] if not file.endswith((".part", ".left"))
]


@pytest.mark.parametrize(("name", "file"), EDITED, ids=[f"{name}: {file}" for name, file in EDITED])
def test_what_was_changed_since_is_never_replaced(name, file, copied, capsys):
    path = Path(file)
    edited_hdf5(path) if path.suffix in (".h5", ".nc") else path.write_bytes(changed(path.read_bytes()))
    refused(COMMANDS[name][0], file, copied, capsys)


@pytest.mark.parametrize("name", QUICK)
def test_what_rsc_wrote_is_replaced_and_with_force_what_anybody_wrote(name, copied):
    command, files = COMMANDS[name]
    assert main(command) == 0
    for file in files:
        if not file.endswith(".left"):
            Path(file).write_bytes(MINE[Path(file).suffix])
    assert main([*command, "--force"]) == 0
    for file in map(Path, files):
        assert not file.exists() if file.suffix in (".part", ".left") else file.read_bytes() != MINE[file.suffix]
    assert main(command) == 0


def test_an_output_is_neither_an_input_nor_another_output(copied, capsys):
    before = content(copied)
    for command in (
        ["run", "m.toml", "-o", "m.toml", "--force"], ["run", "m.toml", "--as-measured", "m.toml", "--force"],
        ["run", "m.toml", "-o", "x.toml", "--as-measured", "x.toml"], ["run", "m.toml", "-o", "x.csv", "--as-measured", "x.toml"],
        ["fit", "probes.toml", "m.toml", "--free", "contact.friction", "-o", "m.toml", "--force"],
        ["fit", "probes.toml", "m.toml", "--free", "contact.friction", "-o", "probes.toml", "--force"],
    ):  # fmt: skip
        assert main(command) == 2 and "another file than those of the command" in capsys.readouterr().err
    assert content(copied) == before


def test_a_store_does_not_take_the_file_of_somebody_for_its_lock(copied, capsys):
    Path("own").mkdir()
    Path("own/lock").write_text("combination 1-2-3")
    assert main(["sweep", "s.toml", *VARY, "-o", "own"]) == 4 and "lock" in capsys.readouterr().err
    assert Path("own/lock").read_text() == "combination 1-2-3"
