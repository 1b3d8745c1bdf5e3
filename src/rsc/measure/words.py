"""Quantities compared, tolerances, and names of the verdicts."""

# the quantities of a window, and the relative difference within which simulation and prediction agree
FREQUENCY, AMPLITUDE, SYNCHRONOUS = "whirl frequency", "whirl amplitude", "synchronous line"
TOLERANCES = {FREQUENCY: 0.005, AMPLITUDE: 0.02, SYNCHRONOUS: 0.05}

AGREES = "agrees"
DIFFERS = "differs"  # beyond the tolerance, and no effect of known size covers it
OUTSIDE = "outside assumptions"  # beyond the tolerance, covered by a named effect whose size was computed
NOT_YET_STEADY = "not yet steady"  # still decays towards its steady motion at the predicted rate
NOT_RESOLVED = "not resolved"  # fewer than three periods in a window
NO_PREDICTION = "no prediction"
NO_WHIRL = "no whirl"
VERDICTS = (AGREES, DIFFERS, NO_PREDICTION, NOT_YET_STEADY, NOT_RESOLVED, OUTSIDE, NO_WHIRL)
