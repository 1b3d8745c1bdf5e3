"""`compare(scene, measured)`: the report of a measured run with the predictions for a scene."""

from dataclasses import replace
from typing import Any

import numpy as np

from rsc.analysis.follow.patience import Note, silent
from rsc.arguments import FUNCTION, RUN, SCENE, takes
from rsc.errors import DataError
from rsc.measure.course import Course
from rsc.measured.measured import Measured
from rsc.measured.run import measured_run
from rsc.scene.scene import Scene
from rsc.study.report.check import compared, observed
from rsc.study.report.nearest import Nearest, nearest_root, with_brings
from rsc.study.report.report import Report
from rsc.system.assemble import assemble

PLACES = 5  # speeds at most at which the model is asked for its root next to the measured whirl


@takes(scene=SCENE, measured=RUN, note=FUNCTION)
def compare(scene: Scene, measured: Measured, note: Note = silent) -> Report:
    """Compare a measured run with the predictions for a scene, window by window, as `rsc.check` does with a simulated one.

    Parameters
    ----------
    scene : Scene
        Rotor, stator and contact; the rotor speed over time is the measured one.
    measured : Measured
        Of `rsc.read_measured`. Its probes stand at the contact.
    note : callable, called every two seconds of a long search for whirls with a line of text

    Returns
    -------
    Report
        `strip`, `stretches` and `stator_fall` are None, the forces in `features` NaN: two probes see neither contact nor force.
        The first of its `warnings` are those of the measurement. `nearest` says at some speeds of the measured whirl which root
        of the scene is next to it, whether it is stable, and which values would make it that whirl.

    Raises
    ------
    DataError
        The measurement has too few samples for a spectrum, or none of its windows is whole.

    Examples
    --------
    >>> scene = rsc.load_scene("laval.toml")
    >>> measured = rsc.read_measured(rsc.write_measured(rsc.simulate(scene), "bench.toml"))
    >>> rsc.compare(scene, measured).agreement
    'frequency agrees within 0.5 % in 97 of 97 windows with a backward line, amplitude within 2 % in 97'
    """
    run: Any = measured_run(measured, scene.turning_forward())  # in the place of a Trajectory
    system = assemble(run.scene)
    seen, grid, whirl_branches = observed(run, system, note)
    if not np.isfinite(seen.order).any():
        raise DataError(measured.source, f"has no window of {seen.fall.window:.3g} s without missing samples: nothing to compare")
    seen = _with_rolls(seen, run.scene)
    report = compared(run, system, seen, grid, whirl_branches, lists=False)
    return replace(report, warnings=[*measured.warnings, *report.warnings], nearest=_roots(run.scene, report))


def _with_rolls(seen: Course, scene: Scene) -> Course:
    """No probe sees whether a whirl rolls: with a contact diameter the whirls predicted to roll are looked at as well."""
    if scene.contact.diameter is None:
        return seen
    whirling = np.array([seen.features.on_whirl(i) for i in range(len(seen.features.speed))])
    return replace(seen, features=replace(seen.features, rolling=np.where(whirling, 1.0, 0.0)))


def _roots(scene: Scene, report: Report) -> tuple[Nearest, ...]:
    """The roots next to the measured whirl at some of its speeds, the first and the last among them."""
    features = report.features
    places = [i for i in range(len(features.speed)) if features.on_whirl(i) and features.frequency[i] < 0.0]
    chosen = dict.fromkeys(places[k] for k in np.linspace(0, len(places) - 1, PLACES).round().astype(int)) if places else {}
    roots = [nearest_root(scene, float(features.speed[i]), float(features.frequency[i])) for i in chosen]
    unlike = [k for k, root in enumerate(roots) if not root.is_that_whirl]
    if unlike:  # which values would do costs seconds: at one speed
        middle = unlike[len(unlike) // 2]
        roots[middle] = with_brings(scene, roots[middle])
    return tuple(roots)
