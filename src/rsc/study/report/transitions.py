"""The changes of whirl of a run, without the rest of its report."""

from rsc.analysis.survey.survey import delays_of
from rsc.arguments import RESULT, takes
from rsc.measure import changes
from rsc.measure.windows import followed
from rsc.results.trajectory import Trajectory
from rsc.study.report.best import best_predictions
from rsc.study.report.check import observed, rolls_of
from rsc.system.assemble import assemble


@takes(result=RESULT)
def transitions(result: Trajectory) -> list[changes.Transition]:
    """Find the changes of a run from one predicted whirl to another or to none: those of its report.

    Parameters
    ----------
    result : Trajectory

    Returns
    -------
    list of rsc.measure.changes.Transition
        In the order of the run; empty if it keeps its whirl or has none.

    Raises
    ------
    DataError
        The run ended before it had samples enough for a spectrum; says how it ended.

    Examples
    --------
    >>> rsc.transitions(rsc.simulate(rsc.load_scene("laval.toml")))  # the run keeps its whirl
    []
    """
    system = assemble(result.scene)
    seen, _, whirl_branches = observed(result, system)
    features = seen.features
    pairs = followed(features, whirl_branches, rolls_of(system, features))
    best, delays = best_predictions(system, features, pairs), delays_of(result.scene, system, whirl_branches)
    return changes.transitions(features, whirl_branches, delays, best)
