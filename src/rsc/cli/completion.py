"""`rsc completion`: shell completion of commands, options and their values, generated from the parsers."""

import argparse
from collections.abc import Iterator
from shlex import quote
from typing import NamedTuple

from rsc.cli.common import OK, Commands

# `-o default`: where none of the words fits the shell completes names of files
_BASH = """\
_rsc() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} place="${COMP_WORDS[*]:1:$((COMP_CWORD-1))} " words=""
    case "$place" in
%s
    esac
    COMPREPLY=($(compgen -W "$words" -- "$word"))
}
complete -o default -F _rsc rsc
"""
_ZSH = "autoload -U +X compinit && compinit\nautoload -U +X bashcompinit && bashcompinit\n" + _BASH


class _Completions(NamedTuple):
    """Completions after some words: words -> help, options -> (help, values); longest commands first."""

    commands: tuple[str, ...]
    words: dict[str, str]
    options: dict[str, tuple[str, tuple[str, ...]]]


def add(commands: Commands) -> None:
    parser = commands("completion", completion_command, "print a shell completion script")
    parser.add_argument("shell", choices=("bash", "zsh", "fish"), metavar="SHELL", help="bash, zsh or fish")


def completion_command(options: argparse.Namespace) -> int:
    from rsc.cli import _parser

    places = list(_places(_parser(), ()))
    print(_fish(places) if options.shell == "fish" else {"bash": _BASH, "zsh": _ZSH}[options.shell] % _cases(places), end="")
    return OK


def _places(parser: argparse.ArgumentParser, commands: tuple[str, ...]) -> Iterator[_Completions]:
    """The completions of all subparsers, then those of the parser itself."""
    words: dict[str, str] = {}
    options: dict[str, tuple[str, tuple[str, ...]]] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            words |= {each.dest: each.help or "" for each in action._choices_actions}
            for name, sub in action.choices.items():
                yield from _places(sub, (*commands, name))
        elif action.option_strings:
            options |= dict.fromkeys(action.option_strings, (action.help or "", tuple(map(str, action.choices or ()))))
        else:
            words |= dict.fromkeys(map(str, action.choices or ()), "")
    yield _Completions(commands, words, options)


def _cases(places: list[_Completions]) -> str:
    lines = []
    for place in places:
        lines.append(f"        {quote(''.join(f'{name} ' for name in place.commands))}*)")
        lines.append(f"            words={quote(' '.join(place.words))}")
        lines.append(f"            [[ $word == -* ]] && words={quote(' '.join(place.options))}")
        for option, (_, values) in place.options.items():
            if values:
                lines.append(f"            [[ $before == {option} ]] && words={quote(' '.join(values))}")
        lines.append("            ;;")
    return "\n".join(lines)


def _fish(places: list[_Completions]) -> str:
    lines = []
    for place in places:
        seen = [f"__fish_seen_subcommand_from {name}" for name in place.commands] or ["__fish_use_subcommand"]
        begin = f"complete -c rsc -n {quote('; and '.join(seen))}"
        lines += [f"{begin} -a {quote(word)} -d {quote(text)}" for word, text in place.words.items()]
        for option, (text, values) in place.options.items():
            named = f"-l {option[2:]}" if option.startswith("--") else f"-s {option[1:]}"
            lines.append(f"{begin} {named} -d {quote(text)}" + (f" -x -a {quote(' '.join(values))}" if values else ""))
    return "\n".join(lines) + "\n"
