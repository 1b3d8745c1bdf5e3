"""The command reference, docs/users/commands.md, written from the parsers of the command line.

    python tools/command_reference.py            writes it
    python tools/command_reference.py --check    says whether it is up to date (exit code 1: it is not)
"""

import argparse
import sys
from pathlib import Path

from rsc.cli import _parser
from rsc.cli.parser import GROUPS

PAGE = Path(__file__).resolve().parents[1] / "docs" / "users" / "commands.md"
HEAD = """# Commands

Every command and its options, written by `python tools/command_reference.py` from the parsers themselves. `rsc COMMAND --help`
prints the same in the terminal, and `eval "$(rsc completion bash)"` has the shell complete them. A mistyped command or option is
refused with exit code 2, the usage of its command and the nearest word that exists.

Answers go to standard output, and with `--json` as JSON; notes, errors and progress go to standard error. Progress is a single
line with the stage, its share and an estimate of the time left, which is written over again and again on a terminal; into a pipe
or a file it is not written. `--quiet` leaves out progress and notes.
"""


def page() -> str:
    """The text of the page."""
    parser = _parser()
    about = {action.dest: action.help or "" for action in parser.commands._choices_actions}
    lines = [HEAD]
    for title, names in GROUPS.items():
        lines.append(f"## {title[0].upper()}{title[1:]}\n")
        for name in names:
            lines += _command(parser.commands.choices[name], f"rsc {name}", about[name])
    return "\n".join(lines).rstrip() + "\n"


def _command(parser: argparse.ArgumentParser, name: str, about: str) -> list[str]:
    """The lines of a command, and those of the kinds that it has."""
    kinds = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    shown = [action for action in parser._actions if action.dest != "help" and action not in kinds]
    usage = " ".join([name, *("KIND" for _ in kinds), *(_usage(action) for action in shown if _is_told(action)), "[options]"])
    lines = [f"### {name}\n", f"{_plain(about[0].upper() + about[1:])}.\n", f"    {usage}\n"]
    if rows := [f"| {_names(action)} | {_plain(_help(action))} |" for action in shown]:
        lines += ["| | |\n|---|---|", *rows, ""]
    for kind in kinds:
        texts = {each.dest: each.help or "" for each in kind._choices_actions}
        for word, sub in kind.choices.items():
            lines += _command(sub, f"{name} {word}", texts[word])
    return lines


def _is_told(action: argparse.Action) -> bool:
    return not action.option_strings or action.required


def _usage(action: argparse.Action) -> str:
    value = _value(action)
    if action.option_strings:
        return f"{action.option_strings[-1]} {value}"
    return f"[{value}]" if action.nargs == "?" else f"{value} [...]" if action.nargs == "+" else value


def _names(action: argparse.Action) -> str:
    value = "" if action.nargs == 0 else f" {_value(action)}" + (" ..." if action.nargs == "+" else "")
    names = reversed(action.option_strings) if action.option_strings else [""]
    first, *others = (f"{name}" for name in names)
    return ", ".join([f"`{(first + value).strip()}`", *(f"`{other}`" for other in others)])


def _value(action: argparse.Action) -> str:
    return str(action.metavar or ("{" + ",".join(map(str, action.choices)) + "}" if action.choices else action.dest.upper()))


def _help(action: argparse.Action) -> str:
    files = {"SCENE": "the file of a scene", "RESULT": "a result of `rsc run` or `rsc check`"}
    return action.help or files.get(_value(action), "")


def _plain(text: str) -> str:
    return text.replace("|", "\\|")


def main() -> int:
    """Write or check the page; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    if parser.parse_args().check:
        same = PAGE.read_text(encoding="utf-8") == page()
        print(f"{PAGE.name} is {'up to date' if same else 'not up to date: python tools/command_reference.py'}")
        return 0 if same else 1
    PAGE.write_text(page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
