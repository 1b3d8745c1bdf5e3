"""Hashes of every reference run, to see that a change keeps the bits.

    python tools/bits.py                         print one line per scene of data/reference and method
    python tools/bits.py --against FILE          compare with what an earlier call printed; exit code 1 where a hash differs
    python tools/bits.py --only laval            of some scenes

A hash covers the samples, counters and energy ledger of a run. Ensembles of some scenes follow, since
they are prepared together.
Bits depend on the processor: compare only what one machine printed.
"""

import argparse
import hashlib
import sys
from dataclasses import astuple
from pathlib import Path

import numpy as np

import rsc

REFERENCE = Path(__file__).resolve().parent.parent / "data" / "reference"
METHODS = ("rk45", "taylor8")
ENSEMBLES = ("laval", "gyroscopic_transition", "mdof_2x2")
GAPS = np.linspace(1.0, 1.02, 11)  # times the scene's


def digest(result):
    """Hash of a run: samples, counters and ledger."""
    summed = hashlib.sha256()
    for name in ("time", "speed", "rotor", "stator", "normal_force"):
        summed.update(np.ascontiguousarray(getattr(result, name)).tobytes())
    counts = (result.steps, result.rejected, result.rhs_calls, result.contact_onsets, result.contact_releases)
    ledger = astuple(result.ledger)
    while len(ledger) > 7 and not ledger[-1]:  # energies that most runs do not have
        ledger = ledger[:-1]
    summed.update(repr((str(result.status), counts, ledger)).encode())
    return summed.hexdigest()[:16]


def ensemble(scene, method):
    """The hashes of runs with many gaps at once as one."""
    gap = scene.contact.gap
    scenes = [scene.with_values({"solver.method": method, "contact.gap": gap * times}) for times in GAPS]
    return hashlib.sha256("".join(map(digest, rsc.simulate_many(scenes, threads=1))).encode()).hexdigest()[:16]


def rows(only=None):
    """(name, hash) of every reference run and ensemble, one after the other, or of these scenes only."""
    for path in sorted(p for p in REFERENCE.glob("*.toml") if ".expected" not in p.name and (not only or p.stem in only)):
        scene = rsc.load_scene(path)
        for method in METHODS:
            yield f"{path.stem} {method}", digest(rsc.simulate(scene.with_values({"solver.method": method})))
            if path.stem in ENSEMBLES:
                yield f"{path.stem} {method} x{len(GAPS)}", ensemble(scene, method)


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--against", type=Path, help="what an earlier call printed")
    parser.add_argument("--only", nargs="+", metavar="SCENE", help="names of scenes")
    options = parser.parse_args()
    before = dict(line.rsplit(" ", 1) for line in options.against.read_text().splitlines()) if options.against else None
    differing = 0
    for name, value in rows(options.only):
        differs = before is not None and before.get(name, value) != value
        differing += differs
        print(f"{name} {value}" + " DIFFERS" * differs, flush=True)
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
