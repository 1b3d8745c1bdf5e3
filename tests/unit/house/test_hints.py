"""Every public function and method of `rsc` has hints on all arguments and on what it returns; mypy reads them in `make lint`."""

import inspect

import pytest

import rsc


def unhinted(thing):
    """Arguments without a hint, of a function or of the public methods of a class; "return" stands for what it returns."""
    if not inspect.isclass(thing):
        called = inspect.signature(thing)
        arguments = {name: each.annotation for name, each in called.parameters.items() if name not in ("self", "cls")}
        hints = {**arguments, "return": called.return_annotation}
        return [name for name, hint in hints.items() if hint is called.empty]
    public = {name: getattr(value, "__func__", value) for name, value in vars(thing).items() if not name.startswith("_")}
    return [f"{name}: {each}" for name, value in public.items() if inspect.isfunction(value) for each in unhinted(value)]


@pytest.mark.parametrize("name", rsc.__all__)
def test_public_names_have_hints(name):
    assert not unhinted(getattr(rsc, name))


def test_a_missing_hint_is_noticed():
    class Bare:
        def method(self, one, two: int):
            pass

    assert unhinted(Bare) == ["method: one", "method: return"]
    assert unhinted(lambda number: number) == ["number", "return"]
