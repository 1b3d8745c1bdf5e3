"""`static` helpers: plain functions whose `if`s about the features of a scene are decided at compile time.

    @question
    def is_driven(con):                       # receives types, evaluated once per kind of scene
        return len(con[con.fields.index("drive")]) > 0

    @static
    def fed_by_speed(con, turn, product):
        if is_driven(con):
            return -0.5 * product
        return -0.5 * turn.omega_dot * product

Numba compiles only the branch that applies: the other one may have different types or none at all. This holds only for an `if`
(or `a if b else c`) whose entire test is a question about parameters, or `not` of one; every other `if` is compiled as usual.
"""

import ast
import copy
import inspect
import textwrap
from functools import cache

from rsc.kernel.simd.jit import unrolled


def question(function):
    """A predicate on Numba types, whether a scene has a feature; `static` helpers apply it to their parameters."""
    function.asked_of_types = True
    return function


def static(function):
    """A helper that is inlined into its caller, with its questions answered at compile time.

    Its source is read when it is first compiled, not when it is imported: compiled code from the disk needs none of it.
    """
    variants = {}

    def choose(*kinds):
        tree, names = parsed(function)
        branches = _Branches(dict(zip(names, kinds, strict=True)), function.__globals__)
        chosen, answers = branches.visit(copy.deepcopy(tree)), tuple(branches.answers)
        if answers not in variants:  # one function for each set of answers, in the globals of its module
            exec(compile(chosen, function.__code__.co_filename, "exec"), function.__globals__, space := {})
            variants[answers] = space[function.__name__]
        return variants[answers]

    helper = unrolled(choose)
    helper.static = function
    return helper


@cache
def parsed(function):
    """(syntax tree of a `static` function, names of its parameters).

    Raises
    ------
    TypeError
        A question that is not the entire test of an `if`, or whose arguments are not parameters: it would receive values.
    """
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    (definition,) = tree.body
    definition.decorator_list = []
    ast.increment_lineno(tree, function.__code__.co_firstlineno - 1)  # so that errors name the line in the source file
    names = [parameter.arg for parameter in definition.args.args]
    _refuse_misplaced(definition, set(names), function.__globals__)
    return tree, names


def _is_question(node, known):
    """Whether a node of a syntax tree calls a question."""
    return isinstance(node, ast.Call) and getattr(known.get(getattr(node.func, "id", "")), "asked_of_types", False)


def _asked(test):
    """(test without leading `not`s, whether their number is odd)."""
    negated = False
    while isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        test, negated = test.operand, not negated
    return test, negated


def _refuse_misplaced(definition, names, known):
    """TypeError for a question that could not select a branch."""
    tests = [_asked(node.test)[0] for node in ast.walk(definition) if isinstance(node, ast.If | ast.IfExp)]
    changed = {node.id for node in ast.walk(definition) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    for node in ast.walk(definition):
        if not _is_question(node, known):
            continue
        place = f"{definition.name}, line {node.lineno}: {ast.unparse(node)}"
        if not any(node is test for test in tests):
            raise TypeError(f"{place}: a question must be the whole test of an if")
        of_parameters = all(isinstance(part, ast.Name) and part.id in names - changed for part in node.args)
        if node.keywords or not of_parameters:
            raise TypeError(f"{place}: a question may only be asked of parameters that are never reassigned")


class _Branches(ast.NodeTransformer):
    """Replaces every `if` on a question by its branch, and drops statements after one that returns."""

    def __init__(self, kinds, known):
        self.kinds, self.known, self.answers = kinds, known, []

    def _answer(self, test):
        """The answer to a test, None if it is not a question."""
        call, negated = _asked(test)
        if not _is_question(call, self.known):
            return None
        asked = self.known[call.func.id](*(self.kinds[part.id] for part in call.args))
        self.answers.append(bool(asked) != negated)
        return self.answers[-1]

    def visit_If(self, node):
        answer = self._answer(node.test)
        if answer is None:
            return self.generic_visit(node)
        return [part for statement in (node.body if answer else node.orelse) for part in self._visited(statement)]

    def visit_IfExp(self, node):
        answer = self._answer(node.test)
        if answer is None:
            return self.generic_visit(node)
        return self.visit(node.body if answer else node.orelse)

    def visit_FunctionDef(self, node):
        body = []
        for statement in node.body:
            body += self._visited(statement)
            if body and isinstance(body[-1], ast.Return):
                break
        node.body = body
        return node

    def _visited(self, statement):
        """List of the statements that replace one."""
        kept = self.visit(statement)
        return kept if isinstance(kept, list) else [kept]
