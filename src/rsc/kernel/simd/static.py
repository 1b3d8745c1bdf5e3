"""`static` helpers: plain functions with plain `if`s, of which those about what a scene has are decided while compiling.

    @question
    def is_driven(con):                       # asked of types, answered once for each kind of scene
        return len(con[con.fields.index("drive")]) > 0

    @static
    def fed_by_speed(con, turn, product):
        if is_driven(con):
            return -0.5 * product
        return -0.5 * turn.omega_dot * product

Numba compiles the branch that applies, as if it had been written alone: the other one may have other types or none. Only an `if`
(or `a if b else c`) whose whole test is a question of parameters, or `not` of one, is decided so; every other `if` is Numba's.
"""

import ast
import copy
import inspect
import textwrap

from rsc.kernel.simd.jit import unrolled


def question(function):
    """A function of types that says whether a scene has something; `static` helpers ask it of their parameters."""
    function.asked_of_types = True
    return function


def static(function):
    """A helper that is merged into its caller, with its questions answered while compiling.

    Raises
    ------
    TypeError
        A question that is not the whole test of an `if`, or is not asked of parameters alone: it would be asked of values.
    """
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    (definition,) = tree.body
    definition.decorator_list = []
    ast.increment_lineno(tree, function.__code__.co_firstlineno - 1)  # errors name the line that was written
    names, variants = [parameter.arg for parameter in definition.args.args], {}
    _refuse_misplaced(definition, set(names), function.__globals__)

    def choose(*kinds):
        branches = _Branches(dict(zip(names, kinds, strict=True)), function.__globals__)
        chosen, answers = branches.visit(copy.deepcopy(tree)), tuple(branches.answers)
        if answers not in variants:  # one function for each set of answers, in the module's own globals
            exec(compile(chosen, function.__code__.co_filename, "exec"), function.__globals__, space := {})
            variants[answers] = space[function.__name__]
        return variants[answers]

    return unrolled(choose)


def _is_question(node, known):
    """Whether a node of a syntax tree is the call of a question."""
    return isinstance(node, ast.Call) and getattr(known.get(getattr(node.func, "id", "")), "asked_of_types", False)


def _asked(test):
    """A test without the `not`s before it, and whether their number is odd."""
    negated = False
    while isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        test, negated = test.operand, not negated
    return test, negated


def _refuse_misplaced(definition, names, known):
    """TypeError of a question that no branch would be chosen by."""
    tests = [_asked(node.test)[0] for node in ast.walk(definition) if isinstance(node, ast.If | ast.IfExp)]
    changed = {node.id for node in ast.walk(definition) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    for node in ast.walk(definition):
        if not _is_question(node, known):
            continue
        place = f"{definition.name}, line {node.lineno}: {ast.unparse(node)}"
        if not any(node is test for test in tests):
            raise TypeError(f"{place}: a question has to be the whole test of an if")
        of_parameters = all(isinstance(part, ast.Name) and part.id in names - changed for part in node.args)
        if node.keywords or not of_parameters:
            raise TypeError(f"{place}: a question is asked of parameters that nothing else is assigned to")


class _Branches(ast.NodeTransformer):
    """Keeps the branch of every `if` that asks a question, and drops what follows a branch that returns."""

    def __init__(self, kinds, known):
        self.kinds, self.known, self.answers = kinds, known, []

    def _answer(self, test):
        """The answer to a test, None if it is no question."""
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
        """The statements that one becomes, a list."""
        kept = self.visit(statement)
        return kept if isinstance(kept, list) else [kept]
