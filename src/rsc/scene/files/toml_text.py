"""Writer of TOML: plain numbers, texts, flags, lists and tables, also inline; what could not be read back is refused."""

import math
from collections.abc import Collection, Mapping
from typing import Any

# characters of a text and how they are written
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\r": "\\r", "\t": "\\t"}


def toml_text(content: Mapping[str, Any], listed: Collection[str] = ()) -> str:
    """TOML text of a dict of values, one level of tables, and lists of tables; floats keep every bit.

    listed : names of tables that are written as `[[name]]` even if there is only one

    Raises
    ------
    TypeError
        A value is not a plain Python number, text, flag or list; the message names its place. This is a bug of the caller.
    """
    tables = {name: part if isinstance(part, list) else [part] for name, part in content.items() if _is_table(part)}
    lines = [f"{key} = {toml_value(value, key)}" for key, value in content.items() if key not in tables]
    for name, several in tables.items():
        head = f"[[{name}]]" if len(several) > 1 or name in listed else f"[{name}]"
        for table in several:
            lines += ["", head] + [f"{key} = {toml_value(value, f'{name}.{key}')}" for key, value in table.items()]
    return "\n".join(lines) + "\n"


def toml_value(value: object, place: str = "value") -> str:
    """A value in TOML notation; TypeError as for `toml_text`."""
    kind = type(value)
    if kind is bool:
        return "true" if value else "false"
    if isinstance(value, str) and kind is str:
        return '"' + "".join(_ESCAPES.get(c) or (c if c.isprintable() else f"\\U{ord(c):08x}") for c in value) + '"'
    if isinstance(value, list) and kind is list:
        items = [toml_value(item, f"{place}[{i}]") for i, item in enumerate(value)]
        if value and isinstance(value[0], list):
            return "[\n" + "".join(f"    {item},\n" for item in items) + "]"
        return "[" + ", ".join(items) + "]"
    if isinstance(value, dict) and kind is dict:
        return "{ " + ", ".join(f"{key} = {toml_value(item, f'{place}.{key}')}" for key, item in value.items()) + " }"
    if kind is int or (isinstance(value, float) and kind is float and math.isfinite(value)):
        return repr(value)
    raise TypeError(f"{place} = {value!r} ({kind.__name__}): must be a finite number, text, flag, list or dict of plain Python")


def _is_table(part: object) -> bool:
    return isinstance(part, Mapping) or (isinstance(part, list) and bool(part) and isinstance(part[0], Mapping))
