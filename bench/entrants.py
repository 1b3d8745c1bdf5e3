"""Who takes part in the work-precision diagrams, and with which tolerances or steps."""

import importlib.metadata
from typing import NamedTuple

import c_code
from peers import cvode_peer, cyrk_peer, exudyn_peer, fixed_step, heyoka_peer, numbalsoda_peer, own, scipy_peers

DECADES = tuple(10.0**-i for i in range(3, 13))
EVERY_OTHER = DECADES[::2]
STEPS = tuple(2**i for i in range(0, 9))
QUICK_TOLERANCES, QUICK_STEPS = (1e-4, 1e-6, 1e-8), (4, 32)


class Entrant(NamedTuple):
    """A method: how to make it for a problem, its settings, and how it is drawn."""

    label: str
    make: object  # problem -> callable(setting, limit) -> Outcome
    settings: tuple  # relative tolerances, or steps between two output times
    family: str
    fixed: bool = False
    quick: bool = True  # takes part in the short run


def _with(maker, *arguments):
    return lambda problem: maker(problem, *arguments)


def entrants(quick=False):
    """All of them in the order of the legend; `quick`: few and with few settings."""
    everyone = [Entrant(f"rsc {method}", _with(own.Rsc, method), DECADES, "rsc") for method in own.RSC_METHODS]
    everyone += [
        Entrant("plain C, rsc's DP5", own.PlainC, DECADES, "yardstick"),
        Entrant("naive Numba DP5", own.Naive, DECADES, "yardstick"),
        # its error lies far below its tolerance, so the loose end of its curve needs looser ones
        Entrant("heyoka, events", heyoka_peer.Heyoka, (1e-1, 1e-2, *DECADES), "compiled"),
    ]
    everyone += [
        Entrant(
            f"CyRK {method}",
            _with(cyrk_peer.CyRK, method),
            EVERY_OTHER if method in slow else DECADES,
            "compiled",
            False,
            method == "Vern7",
        )
        for slow in [("LSODA", "RADAU")]
        for method in cyrk_peer.METHODS
    ]
    everyone += [
        Entrant(f"numbalsoda {method}", _with(numbalsoda_peer.Numbalsoda, method), DECADES, "compiled", False, method == "DOP853")
        for method in numbalsoda_peer.METHODS
    ]
    everyone += [
        Entrant(f"CVODE {method}", _with(cvode_peer.Cvode, method), EVERY_OTHER, "sundials", False, method == "Adams")
        for method in cvode_peer.METHODS
    ]
    everyone += [
        Entrant(f"scipy {method}", _with(scipy_peers.Scipy, method), EVERY_OTHER, "scipy", False, False)
        for method in scipy_peers.METHODS
    ]
    everyone += [
        Entrant(f"{method}, fixed step", _with(fixed_step.Fixed, method), STEPS, "fixed", True) for method in ("RK4", "Newmark")
    ]
    everyone.append(Entrant("Exudyn RK67, fixed step", exudyn_peer.Exudyn, STEPS[:6], "fixed", True, False))
    if not quick:
        return everyone
    return [e._replace(settings=QUICK_STEPS if e.fixed else QUICK_TOLERANCES) for e in everyone if e.quick]


def versions():
    """Versions of everything that runs, the absent ones named."""
    found = []
    for name in ("numba", "numpy", "scipy", "heyoka", "CyRK", "numbalsoda", "scikit-sundae", "exudyn"):
        try:
            found.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            found.append(f"{name} absent")
    return ", ".join([*found, c_code.version()])
