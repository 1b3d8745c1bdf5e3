"""Edits of the package that outlive moves: found by the name of a definition and by an expression or statements inside it.

An edit is `(place, old, new)`. `place` ends the dotted name of a function, a method, a class or a module of the package: `march`,
`contact.law`, `Clock.turned`. `old` is an expression or one or more statements: it is compared as a syntax tree, so that layout,
comments and quotes do not count, and must stand exactly once in all the definitions that `place` names together. `new` takes its
place; an empty one removes them. An empty `old` puts the statements `new` in front of the definition, which must be one.
"""

import ast
import copy
import textwrap
from pathlib import Path
from typing import NamedTuple


class Stale(ValueError):
    """An edit that fits nowhere, or more than once, or leaves no Python behind."""


class Fit(NamedTuple):
    """Where an edit fits: in which file, from which byte to which, at which column its first line begins."""

    path: Path
    first: int
    last: int
    column: int


class Package:
    """The syntax trees of all files of a package, by the dotted names of what they define.

    Parameters
    ----------
    folder : Path
        Folder of the package itself, e.g. src/rsc.
    """

    def __init__(self, folder):
        self.folder = Path(folder)
        self.sources, self.definitions = {}, []  # definitions: (dotted name, path, node)
        for path in sorted(self.folder.rglob("*.py")):
            self._read(path, path.read_bytes())

    def _read(self, path, source):
        self.sources[path] = source
        parts = path.relative_to(self.folder.parent).with_suffix("").parts
        self._define(".".join(part for part in parts if part != "__init__"), path, ast.parse(source))

    def _define(self, name, path, node):
        self.definitions.append((name, path, node))
        for inner in node.body if isinstance(node, (ast.Module, ast.ClassDef)) else ():
            if isinstance(inner, (ast.FunctionDef, ast.ClassDef)):
                self._define(f"{name}.{inner.name}", path, inner)

    def fits(self, place, old):
        """All `Fit` of an edit, each part of a file once."""
        named = [(path, node) for name, path, node in self.definitions if f".{name}".endswith(f".{place}")]
        if not old:
            return [self._fit(path, [node], before=True) for path, node in named]
        wanted = _parsed(old)
        return list(dict.fromkeys(self._fit(path, nodes) for path, node in named for nodes in _equal(node, wanted)))

    def _fit(self, path, nodes, before=False):
        begins = [0]
        for line in self.sources[path].splitlines(keepends=True):
            begins.append(begins[-1] + len(line))
        line, column = min((each.lineno, each.col_offset) for each in (nodes[0], *getattr(nodes[0], "decorator_list", ())))
        column -= bool(getattr(nodes[0], "decorator_list", ()))  # its @
        first = begins[line - 1] + column
        return Fit(path, first, first if before else begins[nodes[-1].end_lineno - 1] + nodes[-1].end_col_offset, column)

    def edited(self, place, old, new):
        """(path, new text) of the one file that an edit changes.

        Raises
        ------
        Stale
            The edit fits nowhere or more than once, or what it leaves is no Python.
        """
        found = self.fits(place, old)
        if len(found) != 1:
            raise Stale(f"{old!r} stands {len(found)} times in {place!r}, not once")
        path, first, last, column = found[0]
        if old and isinstance(_parsed(old), ast.expr):
            text = f"({new or None})"
        else:
            text = textwrap.indent(new.strip("\n") or "pass", " " * column).lstrip() + ("" if old else "\n\n\n" + " " * column)
        source = self.sources[path]
        source = source[:first] + text.encode() + source[last:]
        try:
            ast.parse(source)
        except SyntaxError as error:
            raise Stale(f"{new!r} for {old!r} in {place!r} leaves no Python: {error}") from error
        return path, source.decode()

    def after(self, edits):
        """The package after several edits, one on top of the other; this one and the files stay as they are."""
        package = copy.copy(self)
        for edit in edits:
            changed, text = package.edited(*edit)
            package.sources = dict(package.sources)
            package.definitions = [row for row in package.definitions if row[1] != changed]
            package._read(changed, text.encode())
        return package


def _parsed(text):
    """An expression, or a list of statements."""
    body = ast.parse(textwrap.dedent(text)).body
    return body[0].value if len(body) == 1 and isinstance(body[0], ast.Expr) else body


def _equal(node, wanted):
    """Every node inside, or every run of statements, that is the wanted one."""
    if isinstance(wanted, ast.expr):
        text = ast.unparse(wanted)
        for inner in ast.walk(node):
            if isinstance(inner, type(wanted)) and ast.unparse(inner) == text:
                yield [inner]
        return
    text, length = [ast.unparse(statement) for statement in wanted], len(wanted)
    for inner in ast.walk(node):
        for block in (getattr(inner, name, None) for name in ("body", "orelse", "finalbody")):
            for i in range(len(block) - length + 1 if isinstance(block, list) else 0):
                if [ast.unparse(statement) for statement in block[i : i + length]] == text:
                    yield block[i : i + length]
