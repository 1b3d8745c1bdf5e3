"""The examples in the docstrings of the public functions run, and give what they show."""

import doctest
import inspect

import pytest

import rsc
from rsc.cli import main

SCENES = ("laval", "disk", "pump")  # of `rsc new`, as the reference of the API says (docs/users/api.md)
FUNCTIONS = [name for name in rsc.__all__ if inspect.isfunction(getattr(rsc, name))]
SLOW = {"remedy", "fit", "benchmark"}


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("examples")
    for name in SCENES:
        assert main(["new", name, "-o", str(folder / f"{name}.toml")]) == 0
    return folder


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.nightly] * (name in SLOW)) for name in FUNCTIONS])
def test_the_example_of_a_function_gives_what_it_shows(name, scenes, monkeypatch):
    monkeypatch.chdir(scenes)
    function = inspect.unwrap(getattr(rsc, name))
    (example,) = doctest.DocTestFinder(recurse=False).find(function, name, module=False, globs={"rsc": rsc})
    assert example.examples, f"{name} has no example"
    told = []
    failed, _ = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=told.append, clear_globs=False)
    assert not failed, "".join(told)
    for value in example.globs.values():  # what a notebook shows of a result
        if type(value).__module__.startswith("rsc."):
            assert repr(value).count("\n") < 5 and len(repr(value)) <= 520, repr(value)
