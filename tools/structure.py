"""Size and shape of src, counted in the code itself: of the work tree, and of any commit beside it.

    python tools/structure.py                              the work tree
    python tools/structure.py --against bc10a75 [COMMIT..]  columns of these commits before it
    python tools/structure.py --against bc10a75 --write     keep the table in docs/maintainers/tables/structure.md

A room is a file or folder directly inside src/rsc/analysis, an arrow an import from one to another, and a floor counts from the
rooms that import none. A file writes the law of the contact out where one of the law's constants k_C and b_C is a factor in it.
"""

import argparse
import ast
import io
import re
import subprocess
import tarfile

from pages import ROOT, TABLES, write_page

# as constants of the contact are and were called, here and in the kernel
NAMES = (r"contact_(stiff|damp)\w+", "[kb]_c", r"spring\.k", r"surfaces\.damping", r"law(_of\(system\))?\.(stiffness|damping)")
CONSTANT = re.compile(rf"\b({'|'.join(NAMES)})$")
FRICTION = {"friction", "mu"}
TWO_PI = re.compile(r"^_?TWO_PI$")


def sources(commit=None):
    """Path below src/rsc -> text of every file, of a commit or of the work tree."""
    if commit is None:
        folder = ROOT / "src" / "rsc"
        return {path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8") for path in folder.rglob("*.py")}
    packed = subprocess.run(["git", "archive", commit, "src/rsc"], cwd=ROOT, capture_output=True, check=True).stdout
    with tarfile.open(fileobj=io.BytesIO(packed)) as files:
        names = [name for name in files.getnames() if name.endswith(".py")]
        return {name.removeprefix("src/rsc/"): files.extractfile(name).read().decode() for name in names}


def imported(tree, names):
    """Files among `names` that a module imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("rsc"):
            home = node.module.removeprefix("rsc").lstrip(".").replace(".", "/")
            yield from ({f"{home}.py"} | {f"{home}/{alias.name}.py".lstrip("/") for alias in node.names}) & names


def arrows_of(trees):
    """{(room, room it imports)} of the analysis."""
    places = {name: room_in_analysis(name) for name in trees}
    pairs = {(places[name], places[other]) for name in trees if places[name] for other in imported(trees[name], trees.keys())}
    return {(room, other) for room, other in pairs if other and room != other}


def floors(arrows):
    """Number of floors; arrows go in no circle."""

    def floor(room):
        return 1 + max((floor(other) for own, other in arrows if own == room), default=0)

    return max((floor(room) for room, _ in arrows), default=1)


def room_in_analysis(name):
    inside = name.startswith("analysis/") and not name.endswith("__init__.py")
    return name.split("/")[1] if inside else ""


def writes_law(name, tree):
    """Whether a constant of the contact's law is a factor somewhere in a file, as in every law.py."""
    products = [node for node in ast.walk(tree) if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div)]
    factors = {ast.unparse(part) for node in products for part in ast.walk(node) if isinstance(part, ast.Attribute)}
    return name.endswith("/law.py") or any(map(CONSTANT.search, factors))


def holders(tree):
    """Classes with a number named friction or mu."""
    bodies = (item for node in ast.walk(tree) if isinstance(node, ast.ClassDef) for item in node.body)
    fields = [item for item in bodies if isinstance(item, ast.AnnAssign) and ast.unparse(item.target) in FRICTION]
    return sum(ast.unparse(item.annotation) == "float" for item in fields)


def counts(texts):
    """name of a measure -> its number, of all files of src/rsc."""
    trees = {name: ast.parse(text) for name, text in texts.items()}
    lines = {name: text.count("\n") for name, text in texts.items()}
    arrows = arrows_of(trees)
    named = [node for tree in trees.values() for node in tree.body if isinstance(node, ast.Assign)]
    return {
        "lines of src": sum(lines.values()),
        "lines of the kernel": sum(n for name, n in lines.items() if name.startswith("kernel/")),
        "lines of the analysis": sum(n for name, n in lines.items() if name.startswith("analysis/")),
        "rooms of the analysis": len({room_in_analysis(name) for name in trees} - {""}),
        "arrows between them": len(arrows),
        "floors of them": floors(arrows),
        "files that write the law of the contact out": sum(writes_law(*item) for item in trees.items()),
        "classes that hold the coefficient of friction": sum(map(holders, trees.values())),
        "definitions of two pi": sum(bool(TWO_PI.match(ast.unparse(node.targets[0]))) for node in named),
    }


def table(commits):
    columns = {commit: counts(sources(commit)) for commit in commits} | {"work tree": counts(sources())}
    rows = [f"| | {' | '.join(columns)} |", f"|---|{'---:|' * len(columns)}"]
    rows += [f"| {name} | {' | '.join(str(column[name]) for column in columns.values())} |" for name in columns["work tree"]]
    return "\n".join(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--against", metavar="COMMIT", nargs="+", default=[], help="commits to count as well")
    parser.add_argument("--write", action="store_true", help="keep the table in docs/maintainers/tables")
    options = parser.parse_args()
    text = table(options.against)
    print(text)
    if options.write:
        words = ["--against", *options.against] if options.against else []
        write_page(TABLES / "structure.md", "Size and shape", " ".join(["python tools/structure.py", *words, "--write"]), text)


if __name__ == "__main__":
    main()
