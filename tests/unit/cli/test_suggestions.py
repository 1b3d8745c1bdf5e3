"""What is mistyped is refused with the usage of its command and the word that was meant; the help shows every command once."""

import subprocess
import sys
from pathlib import Path

import pytest

from rsc.cli import _parser, main
from rsc.cli.parser import GROUPS

sys.path.insert(0, str(Path(__file__).parents[3] / "tools"))
import command_reference

MISTYPED = {  # words -> (whose usage, what is suggested)
    "predikt x": ("rsc", "predict"),
    "chek x": ("rsc", "check"),
    "sweeep x": ("rsc", "sweep"),
    "motion x": ("rsc", "motions"),
    "remdy x": ("rsc", "remedy"),
    "improt ross": ("rsc", "import"),
    "scene.toml": ("rsc", "`rsc check scene.toml`"),
    "predict x --sped 50": ("rsc predict", "--speed"),
    "predict --sped 50": ("rsc predict", "--speed"),
    "check x --ouput y": ("rsc check", "--output"),
    "check x --ouput=y": ("rsc check", "--output"),
    "sweep x --treads 2": ("rsc sweep", "--threads"),
    "run x --resum-e": ("rsc run", "--resume"),
    "motions x --strats 3": ("rsc motions", "--starts"),
    "check x --units metrc": ("rsc check", "metric"),
    "new lavel": ("rsc new", "laval"),
    "import fe --stifness k": ("rsc import fe", "--stiffness"),
    "import roos x": ("rsc import", "ross"),
}


@pytest.mark.parametrize("words", MISTYPED)
def test_what_was_meant_is_suggested_below_the_usage_of_its_command(words, capsys):
    usage, meant = MISTYPED[words]
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    told = capsys.readouterr().err
    assert ended.value.code == 2 and told.startswith(f"usage: {usage} [-h]")
    assert told.endswith(f", did you mean {meant}?\n") and told.count("did you mean") == 1


@pytest.mark.parametrize("words", ["frobnicate", "predict x --zzz"])
def test_where_nothing_is_near_nothing_is_suggested(words, capsys):
    with pytest.raises(SystemExit):
        main(words.split())
    assert "did you mean" not in capsys.readouterr().err


def test_the_help_shows_every_command_in_one_group(capsys):
    commands = _parser().commands.choices
    listed = [name for names in GROUPS.values() for name in names]
    assert sorted(listed) == sorted(commands)
    with pytest.raises(SystemExit):
        main(["--help"])
    told = capsys.readouterr().out
    assert all(f"\n{title}:\n" in told for title in GROUPS) and all(told.count(f"\n  {name} ") == 1 for name in listed)


def test_the_help_loads_no_library_of_numbers():
    seen = "import sys; from rsc.cli import _parser; _parser().format_help(); print({'numpy', 'tqdm'} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", seen], capture_output=True, text=True, check=True).stdout == "set()\n"


def test_the_reference_is_current():
    """After a change of commands: python tools/command_reference.py."""
    page = command_reference.PAGE.read_text(encoding="utf-8")
    assert page == command_reference.page()
    for name, parser in _parser().commands.choices.items():
        options = [option for action in parser._actions for option in action.option_strings if option not in ("-h", "--help")]
        section = page.partition(f"### rsc {name}\n")[2].partition("\n### ")[0]
        assert section and all(f"`{option}" in section for option in options)


def test_a_renamed_command_is_told_by_its_present_name(capsys):
    with pytest.raises(SystemExit):
        main(["knock", "x.toml"])
    assert "it is called impact" in capsys.readouterr().err
