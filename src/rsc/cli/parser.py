"""Parsers with suggestions: a mistyped word is refused with the usage of its command and the most similar existing word."""

import argparse
import difflib
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn

# the list of `rsc --help`; a command stands in one group (tested)
GROUPS = {
    "run and report": ("new", "check", "run", "report", "plot"),
    "analysis of a machine": ("predict", "modes", "limits", "motions", "impact", "remedy", "explore"),
    "parameter sweeps": ("sweep",),
    "measured data": ("compare", "fit"),
    "files": ("import", "info", "verify", "completion"),
}
RENAMED = {"knock": ", since version 0.2.0 it is called impact"}


class Parser(argparse.ArgumentParser):
    """The parser of a command; errors show its usage and a suggestion."""

    def __init__(self, *args: Any, **keywords: Any) -> None:
        super().__init__(*args, **keywords)
        self.suggest_on_error = False  # Python's, from 3.14 on, knows of values only
        self._given: list[str] = []

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As in argparse; keeps the arguments for `error`."""
        self._given = [] if args is None else list(args)
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        """Print the usage, the message and the nearest options, if any; exit code 2."""
        unknown = [word.partition("=")[0] for word in self._given if word.startswith("--") and len(word) > 2]
        known = [option for option in self._option_string_actions if option.startswith("--")]
        meant = [_meant(word, known) for word in unknown if not any(option.startswith(word) for option in known)]
        super().error(message + "".join(meant))

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            error.message += _meant(value, [str(choice) for choice in action.choices or ()])
            raise


class MainParser(Parser):
    """The parser of `rsc` itself, whose help shows the commands in groups.

    commands : the action that `add_subparsers` returned
    """

    commands: "argparse._SubParsersAction[Parser]"

    def parse_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """The options of a command; unknown arguments are refused by the parser of that command."""
        import sys

        options, unknown = self.parse_known_args(sys.argv[1:] if args is None else args, namespace)
        if unknown:
            options.parser.error(f"unrecognized arguments: {' '.join(unknown)}")
        del options.parser
        return options

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action is not self.commands or value in self.commands.choices:
            return
        scene = f", did you mean `rsc check {value}`?" if str(value).endswith(".toml") else ""
        hint = scene or RENAMED.get(value, "") or _meant(value, self.commands.choices) or ", `rsc --help` lists them"
        raise argparse.ArgumentError(None, f"there is no command {value!r}{hint}")

    def format_help(self) -> str:
        """The help, with the commands in groups."""
        formatter = self._get_formatter()
        formatter.add_usage(self.usage, self._actions, self._mutually_exclusive_groups)
        formatter.add_text(self.description)
        listed = {action.dest: action for action in self.commands._choices_actions}
        for title, names in GROUPS.items():
            formatter.start_section(title)
            formatter.add_arguments([listed[name] for name in names])
            formatter.end_section()
        formatter.start_section("options")
        formatter.add_arguments([action for action in self._actions if action.option_strings])
        formatter.end_section()
        formatter.add_text("`rsc COMMAND --help` lists the options of a command.")
        return formatter.format_help()


def _meant(word: object, known: Iterable[str]) -> str:
    """The most similar known word, as the end of a message; "" if none is similar."""
    near = difflib.get_close_matches(str(word), list(known), 1, 0.6)
    return f", did you mean {near[0]}?" if near else ""
