"""What pictures say of the stability of a predicted motion along its line."""

import numpy as np

UNSTABLE, STABLE, TOUCHING = 0.0, 1.0, 2.0

# word in a legend -> of a line, which of the values of `stability` it is
CLAIMS = {
    "stable": lambda value: value == STABLE,
    "touches a clearance": lambda value: value == TOUCHING,
    "unstable": lambda value: value == UNSTABLE,
    "not circular: stability not assessed": np.isnan,
}


def stability(line):
    """(n,) 1 where a whirl or forward rub is stable, 0 where it is not, 2 where small motions decay and it touches a place that
    is only watched, NaN where it is no circle because directions differ: of such a motion nothing is claimed.

    line : with growth_rate, stable and touches, (n,) each: `rsc.analysis.follow.branch.Branch`,
        `rsc.analysis.follow.forward_rub.RubRange`
    """
    touching = np.array([bool(own) for own in line.touches], dtype=bool)
    decaying = np.where(line.stable, STABLE, np.where(touching, TOUCHING, np.nan))
    return np.where(line.stable | (line.growth_rate < 0.0), decaying, UNSTABLE)


def parts(value, exists):
    """Word in the legend -> (n,) bool, where a line of that kind is drawn: without a hole where one kind changes to another.

    value : (n,) as from `stability`; exists : (n,) bool, where there is anything
    """
    value, drawn = np.asarray(value, dtype=float), {}
    for word, chosen in CLAIMS.items():
        own = exists & chosen(value)
        if word != "stable":  # whose ends stay exact
            joined = own.copy()
            joined[:-1] |= own[1:]
            joined[1:] |= own[:-1]
            own = joined & exists
        if own.any():
            drawn[word] = own
    return drawn
