"""Values of a shaft or machine that change together in a remedy, and their names: its bearings are one matrix when it is read."""

from rsc.scene.scene import Scene

# a lever of a reduced body -> its matrices; the internal, rotating damping of a shaft drives it forward and is left out
_TOGETHER = {
    "damping": tuple(
        f"{kind}damping{ending}" for kind in ("", "skew_", "anisotropic_") for ending in ("", "_knots", "_until")
    )
}  # fmt: skip
_SHAFT = {"damping": "damping of all {body} bearings", "unbalance": "all unbalances of the {body}"}
_MACHINE = {"damping": "all damping of the {body} (bearings and structure)", "unbalance": "all unbalances of the {body}"}


def is_of(name: str, key: str) -> bool:
    """Whether a value is that of a key, in its list, or in a matrix that changes with it; of an eccentricity the amounts, not the
    angles."""
    own, (table, _, last) = name.partition("[")[0], key.rpartition(".")
    if own not in {key, *(f"{table}.{other}" for other in _TOGETHER.get(last, ()))}:
        return False
    return not (key.endswith("eccentricity") and name.endswith("[1]"))


def shown_name(scene: Scene, name: str) -> str:
    """A lever as the user's scene calls it: what is read from stations or finite elements is matrices, which no scene names."""
    table, _, key = name.rpartition(".")
    body = getattr(scene, table, None)
    if getattr(body, "model", "") != "reduced":
        return name
    words = _SHAFT if getattr(body, "drawn", None) else _MACHINE
    return words.get(key, name).format(body=table)
