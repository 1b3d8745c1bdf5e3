"""What pictures say of the stability of a predicted motion along its line."""

import numpy as np

# word in a legend -> of a line, which of the values of `stability` it is
CLAIMS = {
    "stable": lambda value: value > 0.5,
    "unstable": lambda value: value <= 0.5,
    "no circle: nothing claimed": np.isnan,
}


def stability(line):
    """(n,) 1 where a whirl or forward rub is stable, 0 where it is not, NaN where it is no circle because directions differ: of
    such a motion nothing is claimed.

    line : with growth_rate and stable, (n,) each: `rsc.analysis.lines.branches.Branch`, `rsc.analysis.lines.forward_rub.RubRange`
    """
    return np.where(line.stable, 1.0, np.where(line.growth_rate < 0.0, np.nan, 0.0))


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
