"""How results present themselves: in few lines, and through the door of `show`, which draws what it may import, not they it."""

import textwrap
from dataclasses import fields, is_dataclass
from importlib import import_module
from typing import Any, TypeVar

T = TypeVar("T")

LINES, WIDTH, WORTH = 5, 100, 60  # of a repr, and characters of one value


class Brief:
    """A dataclass (`repr=False`) whose repr tells kinds and sizes in at most five lines."""

    def __repr__(self) -> str:
        return _folded(_one_line(self))


class BriefList(list[T]):
    """A list whose repr tells how long it is and how its first entries look."""

    def __repr__(self) -> str:
        entries = "".join(f"\n  {_cut(_short(each, 90), 90)}" for each in self[: LINES - 2])
        return (
            f"{type(self).__name__} of {len(self)}"
            + (":" + entries if self else "")
            + ("\n  ..." if len(self) > LINES - 2 else "")
        )


def drawing() -> Any:
    """The module that draws results. By name: imports go down, and show stands above the results that it draws."""
    return import_module("rsc.show.pictures.of_results")


def _one_line(value: Brief) -> str:
    shown = (each for each in fields(value) if each.repr)  # type: ignore[arg-type]
    return f"{type(value).__name__}({', '.join(f'{each.name}={_short(getattr(value, each.name))}' for each in shown)})"


def _short(value: object, worth: int = WORTH) -> str:
    """A value in few characters: its kind and size where it is long."""
    shape = getattr(value, "shape", None)
    if shape:
        return f"<{getattr(value, 'dtype', 'array')} {shape}>"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple, dict)) and (len(value) > 3 or len(repr(value)) > worth):
        return f"<{type(value).__name__} of {len(value)}>"
    if isinstance(value, Brief) and worth > WORTH:
        return _one_line(value)
    text = repr(value)
    if is_dataclass(value) and len(text) > worth:
        return f"<{type(value).__name__}>"
    return _cut(text, worth)


def _cut(text: str, most: int) -> str:
    return text if len(text) <= most else text[: most - 3] + "..."


def _folded(text: str) -> str:
    lines = textwrap.wrap(text, WIDTH, subsequent_indent="  ", break_long_words=True)
    return "\n".join(lines if len(lines) <= LINES else [*lines[: LINES - 1], "  ...)"])
