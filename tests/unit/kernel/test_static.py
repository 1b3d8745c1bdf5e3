"""`static` helpers: a question chooses the code while compiling, and one that could not is refused when it is compiled."""

import ast
from importlib import import_module
from pathlib import Path

import numba
import pytest

import rsc
from rsc.kernel import questions
from rsc.kernel.simd.jit import entry
from rsc.kernel.simd.static import parsed, question, static

KERNEL = Path(rsc.__file__).parent / "kernel"


@question
def is_empty(kind):
    return not len(kind)


@question
def is_pair(kind):
    return len(kind) == 2


@static
def total(values):
    """Sum of a tuple: without the branch for () a type error, since () has no first."""
    if is_empty(values):
        return 0.0
    return values[0] + total(values[1:])


@static
def kind_of(values, x):
    if not is_empty(values):
        if x > 0.0:
            return 2.0 if is_pair(values) else 3.0
        return -1.0
    return ()  # of another type


@entry
def totals():
    return total(()), total((1.0,)), total((1.0, 2.0, 4.0))


@entry
def kinds(x):
    return kind_of((), x), kind_of((1.0, 2.0), x), kind_of((1.0, 2.0, 3.0), x)


def test_the_branch_that_applies_is_compiled_alone():
    assert totals() == (0.0, 1.0, 7.0)
    assert kinds(1.0) == ((), 2.0, 3.0)
    assert kinds(-1.0) == ((), -1.0, -1.0)


def asked_of_a_value(values):
    first = values[0]
    if is_empty(first):
        return 1.0
    return 0.0


def asked_of_a_changed_parameter(values):
    values = values[1:]
    if is_empty(values):
        return 1.0
    return 0.0


def asked_with_another_condition(values, x):
    if is_empty(values) and x:
        return 1.0
    return 0.0


def asked_without_an_if(values):
    return is_empty(values)


def asked_in_a_loop(values):
    while is_empty(values):
        return 1.0
    return 0.0


@pytest.mark.parametrize(
    ("misplaced", "reason"),
    [
        (asked_of_a_value, "asked of parameters"),
        (asked_of_a_changed_parameter, "asked of parameters"),
        (asked_with_another_condition, "whole test"),
        (asked_without_an_if, "whole test"),
        (asked_in_a_loop, "whole test"),
    ],
)
def test_a_misplaced_question_is_refused(misplaced, reason):
    with pytest.raises(TypeError, match=rf"{misplaced.__name__}, line \d+: .*{reason}"):
        parsed(misplaced)


def test_no_question_of_the_kernel_is_misplaced():
    """None waits to be refused until a scene comes that compiles it."""
    modules = [import_module(f"rsc.kernel.{path.stem}") for path in sorted(KERNEL.glob("*.py")) if path.stem != "__init__"]
    own = {value.static for module in modules for value in vars(module).values() if hasattr(value, "static")}
    assert len(own) > 100
    for function in own:
        parsed(function)


def asked(tree, names):
    """Functions of a module that ask one of some questions, with the names of their decorators."""
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            calls = {getattr(node.func, "id", "") for node in ast.walk(function) if isinstance(node, ast.Call)}
            if calls & names:
                yield function.name, {ast.unparse(decorator) for decorator in function.decorator_list}


def test_questions_of_the_kernel_are_asked_where_they_are_decided():
    """In a function that is neither static, nor itself run while compiling, a question would be asked of values."""
    names = {name for name, value in vars(questions).items() if getattr(value, "asked_of_types", False)}
    assert len(names) > 5
    for path in sorted(KERNEL.rglob("*.py")):
        for name, decorators in asked(ast.parse(path.read_text(encoding="utf-8")), names):
            assert decorators & {"static", "question", "unrolled"}, f"{path.name}: {name}"


def test_an_error_names_the_line_that_was_written():
    @static
    def wrong(x):
        return x.no_such_field

    @entry
    def caller(x):
        return wrong(x)

    with pytest.raises(numba.core.errors.TypingError) as told:
        caller(1.0)
    assert Path(__file__).name in str(told.value)
