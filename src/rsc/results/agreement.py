"""Does what a result file holds agree with the scene and the summary in it, and that with the scene of the one who resumes it?"""

import math

import numpy as np

from rsc.errors import SceneError
from rsc.measure.stretches import COLUMNS, EXTENTS
from rsc.results.result_format import columns_of
from rsc.results.summary import Status

MOST_LETTERS = 100_000  # of advice and versions; every resuming with other versions adds some hundred
LARGEST_COUNT = 2**62
MOST_SPEED, STANDS = 1e6, 1e-3  # Hz: that a scene may have, and what is left where a rotor stops
_POSITIVE = [
    i for i, name in enumerate(COLUMNS)
    if name not in EXTENTS and name.endswith(("_max", "_min", "_time", "_at", "onsets", "normal_impulse"))
]  # fmt: skip


def refuse_impossible(summary):
    """ValueError for a Summary that no run has."""
    counts = ("steps", "rejected", "rhs_calls", "switches", "contact_onsets", "contact_releases")
    for name in counts:
        if not 0 <= getattr(summary, name) <= LARGEST_COUNT:
            raise ValueError(f"{name} of its summary is no count")
    for name in ("end_time", "contact_time", "least_diameter", "sliding_lost"):
        if not getattr(summary, name) >= 0.0:
            raise ValueError(f"{name} of its summary is negative")
    if not (0.0 < summary.rtol < 1.0 and summary.end_time < math.inf and summary.contact_time <= summary.end_time * (1.0 + 1e-6)):
        raise ValueError("the times or the tolerance of its summary are impossible")
    for name in ("advice", "versions"):
        text = getattr(summary, name)
        if len(text) > MOST_LETTERS or not text.isprintable():
            raise ValueError(f"{name} of its summary is no line of text")


def refuse_other_scene_than_samples(scene, counts, rows):
    """ValueError unless the coordinates of every motion (name -> number) and the samples are as many as in runs of a scene."""
    for name, kept in columns_of(scene).items():
        if counts[name] != kept:
            raise ValueError(f"{name} has {counts[name]} coordinates, in runs of the stored scene {kept}")
    if rows > scene.drive.duration * scene.output.rate + 2.0:
        raise ValueError(f"it holds {rows} samples, more than a run of the stored scene has")


def refuse_other_end(scene, summary, rows):
    """ValueError for an end that a run of the scene cannot have."""
    duration = scene.drive.duration
    ended = summary.status in (Status.FINISHED, Status.OUT_OF_ASSUMPTIONS)
    if summary.end_time > duration or (ended and summary.end_time < duration):
        raise ValueError(f"a run of the stored scene that is {summary.status} does not end at {summary.end_time:.6g} s")
    if abs(rows - summary.end_time * scene.output.rate) > 2.0 + 1e-9 * rows:
        raise ValueError(f"a run that ended at {summary.end_time:.6g} s has not {rows} samples")


def refuse_other_stretches(scene, stretches, summary):
    """ValueError for facts that a run with this summary cannot have."""
    if stretches.deflections.shape[1] != len(scene.clearances):
        raise ValueError("its stretches are not those of its clearances")
    end, least = stretches.end, np.diff(stretches.end, prepend=0.0)
    if not (np.isfinite(end).all() and (least > 0.0).all() and end[-1:].sum() == summary.end_time):
        raise ValueError("its stretches are not those of its time")
    if not (stretches.rows[:, _POSITIVE] >= 0.0).all() and summary.status in (Status.FINISHED, Status.OUT_OF_ASSUMPTIONS):
        raise ValueError("a size of its stretches is negative")
    if not (stretches.y_min <= stretches.y_max).all() or not (stretches.z_min <= stretches.z_max).all():
        raise ValueError("extents of its stretches are impossible")
    passed = stretches.passed
    if not ((stretches.deflections >= 0.0).all() and ((passed >= 0.0) & ((passed <= end[:, None]) | (passed == math.inf))).all()):
        raise ValueError("a passage of a gap in its stretches is impossible")
    if not (stretches.contact_time <= least * (1.0 + 1e-6) + 1e-9 * end[-1:].sum()).all():
        raise ValueError("its stretches are in contact for longer than they last")


def refuse_other_times(scene, name, values, first=0):
    """ValueError unless the samples of "time", "speed" or "angle", from number `first` on, are those of the scene, or of a drive
    with a torque can be."""
    if name != "time" and scene.drive.inertia is not None:
        least, most = (0.0, 1.0) if name == "angle" else (-STANDS, MOST_SPEED)
        if not ((values >= least) & (values <= most)).all():
            raise ValueError(f"{name} is not that of a drive with a torque")
        return
    times = np.arange(first, first + len(values)) / scene.output.rate
    expected = times if name == "time" else np.interp(times, scene.drive.time, scene.drive.speed)
    scale = 1.0 / scene.output.rate if name == "time" else max(map(abs, scene.drive.speed))
    if not np.allclose(values, expected, rtol=1e-9, atol=1e-9 * scale):
        raise ValueError(f"{name} is not that of the stored scene")


def refuse_other_scene(path, stored, scene):
    """SceneError naming the first key in which the scene of a run to be resumed differs from the one given."""
    old, new = _flat(stored.to_dict()), _flat(scene.to_dict())
    for key in sorted(old.keys() | new.keys()):
        if old.get(key) != new.get(key):
            expected = f"{old.get(key)!r}, as in the run to be resumed"
            raise SceneError(scene.source, key, new.get(key), expected, f"{path} was made with another scene")


def _flat(mapping, prefix=""):
    flat = {}
    for key, value in mapping.items():
        if isinstance(value, dict):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[prefix + key] = value
    return flat
