"""Size and shape of src, counted in the code itself: of the work tree, and of any commit beside it.

    python tools/structure.py                               the work tree
    python tools/structure.py --against bc10a75 [COMMIT..]  columns of these commits before it
    python tools/structure.py --against bc10a75 --write     keep the table in docs/maintainers/tables/structure.md

A token is one of Python's own, without comments and layout; a docstring counts as one. A feature is what a user would name, and
holds its files in all wings (`FEATURES`); what no feature names counts as its wing. A room is a folder directly in a wing; the
files directly inside the wing together are one more. An arrow is an import, for types alone too, from one room to another.
A file writes the law of the contact out where one of the law's constants k_C and b_C is a factor in it.
"""

import argparse
import ast
import io
import re
import subprocess
import tarfile
import tokenize
from collections import Counter

from pages import ROOT, TABLES, write_page

LAYOUT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
WINGS = ("analysis", "scene", "machine", "show", "study")
# feature -> files below src/rsc that belong to it, whatever their wing
FEATURES = {
    "measured runs and fits": r"measured/|.*/(compare|compared|nearest|fit|fitted)(/|\.py)",
    "sweeps": r".*sweep",
    "several contacts": r".*several|.*at_contacts?\.py",
    "torque-limited drives": r".*/(drive|driven|held|torques|load)\.py",
    "races": r".*/races?\.py",
    "coefficients that follow the speed": r".*/(by_speed|following|knots|at_speed)\.py",
    "finite-element machines": r"machine/|.*/(machines|reduced|reductions|import_model)\.py",
    "motions, impacts, remedies": r".*/(motions|settle|impact|smallest_impulse|impulses|catalogue|kinds|final|remedy)(/|\.py)",
    "clearances and limits": r".*/(clearances|limits|watched)\.py",
    "report page": r"show/page|.*/(stored|headline|answer)\.py",
    "pictures": r"show/pictures/",
    "result files": r"results/|files/",
    "operating systems": r"operating_system/",
    "fast compilation": r"compiled/",
}
# as constants of the contact are and were called, here and in the kernel
NAMES = (r"contact_(stiff|damp)\w+", "[kb]_c", r"spring\.k", r"surfaces\.damping", r"law(_of\(system\))?\.(stiffness|damping)")
CONSTANT = re.compile(rf"\b({'|'.join(NAMES)})$")
FRICTION = {"friction", "mu"}


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
            files = {f"{home}/{alias.name}.py".lstrip("/") for alias in node.names} & names
            yield from files or {f"{home}.py", f"{home}/__init__.py"} & names


def room_in(wing, name):
    """The room of a file of a wing; its name is empty for files directly inside the wing, None outside it."""
    inside = name.removeprefix(f"{wing}/")
    return None if inside == name or inside == "__init__.py" else inside.rpartition("/")[0].partition("/")[0]


def arrows_of(trees, wing):
    """{(room, room it imports)} of a wing."""
    places = {name: room_in(wing, name) for name in trees}
    pairs = {(places[name], places[other]) for name in trees for other in imported(trees[name], trees.keys())}
    return {(room, other) for room, other in pairs if None not in (room, other) and room != other}


def circles(arrows):
    """How many rooms reach themselves along arrows."""
    reached = set(arrows)
    while more := {(a, d) for a, b in reached for c, d in arrows if b == c} - reached:
        reached |= more
    return len({a for a, b in reached if a == b})


def shape(trees, wing):
    """Rooms / arrows / circles of a wing in one text."""
    arrows = arrows_of(trees, wing)
    rooms = {room_in(wing, name) for name in trees} - {None}
    return f"{len(rooms)} / {len(arrows)} / {circles(arrows)}"


def tokens(text):
    """Number of tokens of code in a text."""
    return sum(token.type not in LAYOUT for token in tokenize.generate_tokens(io.StringIO(text).readline))


def feature_of(name):
    """The feature that a file belongs to, else its wing."""
    named = (feature for feature, files in FEATURES.items() if re.match(files, name))
    return next(named, name.partition("/")[0].removesuffix(".py"))


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


def shared_names(trees):
    """Number of names that more than one public class has."""
    classes = [node.name for tree in trees.values() for node in tree.body if isinstance(node, ast.ClassDef)]
    return sum(count > 1 for name, count in Counter(classes).items() if not name.startswith("_"))


def hinted(trees):
    """Share of the arguments of functions outside compiled code that have a hint, in percent."""
    plain = [tree for name, tree in trees.items() if not name.startswith(("kernel/", "compiled/", "simulation/"))]
    functions = [node for tree in plain for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    given = [a for f in functions for a in (*f.args.posonlyargs, *f.args.args, *f.args.kwonlyargs)]
    hints = [a.annotation is not None for a in given if a.arg not in ("self", "cls")]
    return round(100 * sum(hints) / max(1, len(hints)))


def counts(texts):
    """name of a measure -> its number, of all files of src/rsc."""
    trees = {name: ast.parse(text) for name, text in texts.items()}
    lines = {name: text.count("\n") for name, text in texts.items()}
    kernel = "\n".join(text for name, text in texts.items() if name.startswith("kernel/"))
    sizes = Counter()
    for name, text in texts.items():
        sizes[feature_of(name)] += tokens(text)
    whole = {
        "lines of src": sum(lines.values()),
        "lines of the kernel": sum(n for name, n in lines.items() if name.startswith("kernel/")),
        "lines of the analysis": sum(n for name, n in lines.items() if name.startswith("analysis/")),
        **{f"rooms / arrows / rooms in circles: {wing}": shape(trees, wing) for wing in WINGS},
        "lambdas of the kernel": len(re.findall(r"\blambda\b", kernel)),
        "functions that are chosen while compiling": len(re.findall(r"^@unrolled", kernel, re.MULTILINE)),
        "names that more than one class has": shared_names(trees),
        "arguments with a hint outside compiled code, %": hinted(trees),
        "files that write the law of the contact out": sum(writes_law(*item) for item in trees.items()),
        "classes that hold the coefficient of friction": sum(map(holders, trees.values())),
        "tokens of code": sum(sizes.values()),
    }
    return whole | {f"tokens: {feature}": size for feature, size in sizes.most_common()}


def table(commits):
    columns = {commit: counts(sources(commit)) for commit in commits} | {"work tree": counts(sources())}
    names = dict.fromkeys(name for column in reversed(columns.values()) for name in column)
    rows = [f"| | {' | '.join(columns)} |", f"|---|{'---:|' * len(columns)}"]
    rows += [f"| {name} | {' | '.join(str(column.get(name, '-')) for column in columns.values())} |" for name in names]
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
