"""Forms of a table, i.e. alternative sets of keys: which keys each form requires and allows, and what follows from that.

Every declared key belongs to a form, which is checked when the class is created (`declared_in`). The forms determine which keys
exclude each other, for reading and changing tables, and the error for an incomplete form.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import Any, NamedTuple, TypeVar

from rsc.scene.keys.keys import OPTIONAL, RawTable, Values, known_keys

_Section = TypeVar("_Section", bound=type[Any])


class Form(NamedTuple):
    """A set of keys that a table may have: all of `needed`, any of `more`."""

    needed: tuple[str, ...]
    more: tuple[str, ...] = ()

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys allowed in the form."""
        return self.needed + self.more


def exclusive(forms: Sequence[Form]) -> tuple[tuple[tuple[str, str], object], ...]:
    """Pairs of keys that no form combines, as groups for `one_of`; one of a pair is required if every form needs one of them."""
    keys = list(dict.fromkeys(key for form in forms for key in form.keys))
    pairs = [pair for pair in combinations(keys, 2) if not any(set(pair) <= set(form.keys) for form in forms)]
    return tuple((pair, None if all(set(pair) & set(form.needed) for form in forms) else OPTIONAL) for pair in pairs)


def declared_in(section: _Section) -> _Section:
    """Decorator of a class of keys with `forms`: TypeError for a key that is in no form or not declared."""
    forms = section.forms
    declared: Any = section
    stray = set(known_keys(declared)) ^ {key for form in forms for key in form.keys}
    if stray:
        raise TypeError(f"{section.__name__}.{min(stray)}: a key must be declared and belong to a form")
    return section


def form_of(forms: Sequence[Form], table: RawTable, values: Values) -> Form:
    """The form of a table: among those that allow all present keys the one with the fewest missing.

    Raises
    ------
    SceneError
        A required key is missing, or no form allows all present keys.
    """
    present = [key for key in values if key in table.values]
    fitting = [form for form in forms if set(present) <= set(form.keys)]
    if not fitting:
        wanted = "left out, or others of " + ", ".join(present)
        table.refuse(present[-1], table.values[present[-1]], wanted, f"they do not go together in [{table.name}]")
    form = min(fitting, key=lambda form: len(set(form.needed) - set(present)))
    for key in form.needed:
        if key not in present:
            table.refuse(key, None, f"given: {', '.join(form.needed)} go together in [{table.name}]")
    return form
