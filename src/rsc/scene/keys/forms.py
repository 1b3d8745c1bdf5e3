"""Forms of a table whose keys go together in several ways: which keys each needs and may have, and what follows from that.

Every declared key stands in some form, which is checked when the class is made (`declared_in`). From the forms follow the groups
of keys that exclude each other, by which tables are read and changed, and the refusal of a form that is not whole.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import Any, NamedTuple, TypeVar

from rsc.scene.keys.keys import OPTIONAL, RawTable, Values, known_keys

_Section = TypeVar("_Section", bound=type[Any])


class Form(NamedTuple):
    """Keys that a table has together: all of `needed`, any of `more`."""

    needed: tuple[str, ...]
    more: tuple[str, ...] = ()

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys that it may have."""
        return self.needed + self.more


def exclusive(forms: Sequence[Form]) -> tuple[tuple[tuple[str, str], object], ...]:
    """Pairs of keys that no form has together, as groups for `one_of`; one of a pair must be given where every form needs one."""
    keys = list(dict.fromkeys(key for form in forms for key in form.keys))
    pairs = [pair for pair in combinations(keys, 2) if not any(set(pair) <= set(form.keys) for form in forms)]
    return tuple((pair, None if all(set(pair) & set(form.needed) for form in forms) else OPTIONAL) for pair in pairs)


def declared_in(section: _Section) -> _Section:
    """Decorator of a class of keys with `forms`: TypeError, which names it, for a key in no form or one that is not declared."""
    forms = section.forms
    declared: Any = section
    stray = set(known_keys(declared)) ^ {key for form in forms for key in form.keys}
    if stray:
        raise TypeError(f"{section.__name__}.{min(stray)}: a key must be declared and stand in a form")
    return section


def form_of(forms: Sequence[Form], table: RawTable, values: Values) -> Form:
    """The form of a table: of those that may have all keys that are given the one that lacks least.

    Raises
    ------
    SceneError
        A key that it needs is missing, or no form may have all that are given.
    """
    present = [key for key in values if key in table.values]
    fitting = [form for form in forms if set(present) <= set(form.keys)]
    if not fitting:
        wanted = "left out, or others of " + ", ".join(present)
        table.refuse(present[-1], table.values[present[-1]], wanted, f"no form of [{table.name}] has them all")
    form = min(fitting, key=lambda form: len(set(form.needed) - set(present)))
    for key in form.needed:
        if key not in present:
            table.refuse(key, None, f"given: {', '.join(form.needed)} go together in [{table.name}]")
    return form
