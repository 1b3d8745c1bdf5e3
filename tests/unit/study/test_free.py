"""Values of a scene that a fit may change."""

import pytest

import rsc
from rsc.errors import SceneError
from rsc.study.fit.free import free_values
from scenes import DRIVEN

SCENE = rsc.Scene.from_dict(DRIVEN)


@pytest.mark.parametrize(
    "name",
    ["solver.rtol", "solver.divergence", "output.rate", "drive.inertia", "drive.trip", "drive.duration", "start.whirl",
     "limits.maximum_continuous", "clearance.seal.gap"],
)  # fmt: skip
def test_values_that_no_measurement_determines_are_refused(name):
    with pytest.raises(SceneError, match=r"must be a value of rotor, stator or contact \(no measurement determines it\)"):
        free_values(SCENE, [name], {name: "1:2"})


def test_the_title_is_no_value_and_is_not_proposed():
    with pytest.raises(SceneError, match=r"title = .*\(the title is not a value\)"):
        free_values(SCENE, ["title"], {})


def test_a_unit_that_stands_once_in_a_range_holds_for_both_ends():
    (free,) = free_values(SCENE, ["contact.gap"], {"contact.gap": "0.1:0.4 mm"})
    assert (free.low, free.high) == (1e-4, 4e-4)
    with pytest.raises(SceneError, match="that all have a unit"):
        free_values(SCENE, ["contact.gap"], {"contact.gap": (0.1, "0.4 mm")})
