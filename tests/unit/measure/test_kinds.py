"""The kind of a motion, from facts that are known."""

from dataclasses import replace

import pytest

from rsc.measure.kinds import Kind, motion_of
from rsc.measure.stretches import Facts

GAP, DURATION, SPEED = 1e-3, 1.0, 50.0
STILL = Facts(
    begin=0.0, end=DURATION, turns=0.0, pressed_turns=0.0, contact_time=DURATION, rolling_time=0.0, onsets=0.0, friction_work=0.0,
    rotor_max=1.2e-3, rotor_min=1e-3, stator_max=1e-4, deflection_max=1.1e-3, force_max=7.0, arc_y=0.0, arc_z=0.0,
    normal_impulse=5.0, friction_impulse=1.0, drive_work=0.0, race_work=0.0, rotor_max_at=0.0, deflection_max_at=0.0,
    force_max_at=0.0, y_min=-1e-3, y_max=1e-3, z_min=-1e-3, z_max=1.2e-3,
)  # fmt: skip


def parts(turns, share=1.0, rolling=0.0, arc=0.0, work=1.0, onsets=6.0):
    """Facts of parts that last as long, each with turns of its own."""
    length = DURATION / len(turns)
    return [
        replace(
            STILL, begin=i * length, end=(i + 1) * length, turns=own, contact_time=share * length,
            rolling_time=rolling * share * length, arc_y=arc * GAP * share * length, friction_work=work, onsets=onsets,
        )
        for i, own in enumerate(turns)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("own", "kind"),
    [
        (parts([6.0] * 8, share=0.0), Kind.NO_CONTACT),
        (parts([6.25] * 8), Kind.FORWARD_RUB),
        (parts([6.33] * 8), Kind.FORWARD_RUB),  # 0.64 turns more than the shaft: as well as its end is known
        (parts([7.0] * 8), Kind.FORWARD_WHIRL),
        (parts([7.0] * 8, share=0.9), Kind.PARTIAL_RUB),  # of what only the unbalance feeds
        (parts([-8.0] * 8), Kind.SLIDING),
        (parts([-8.0] * 8, rolling=0.4), Kind.SLIDING),
        (parts([-8.0] * 8, rolling=0.6), Kind.ROLLING),
        (parts([-8.0] * 8, share=0.8), Kind.BOUNCING),
        (parts([-8.0] * 8, share=0.8, work=0.0), Kind.PARTIAL_RUB),  # nothing feeds it
        (parts([-8.0] * 7 + [1.0], share=0.8), Kind.PARTIAL_RUB),  # no lasting sense
        (parts([6.25] * 8, share=0.3), Kind.PARTIAL_RUB),
        (parts([0.1, -0.1] * 4, arc=0.9), Kind.RESTING),
        (parts([0.1, -0.1] * 4, arc=0.3), Kind.PARTIAL_RUB),
        (parts([-3.0, 3.0] * 4, arc=0.0), Kind.PARTIAL_RUB),  # to and fro, all round
    ],
)
def test_a_motion_has_its_kind(own, kind):
    motion = motion_of(own, SPEED * DURATION, GAP)
    assert motion.kind == kind and motion.why == ""


def touched(turns, onsets, share=0.05):
    """Parts of a free vibration that touches so often in each."""
    pairs = zip(parts(turns), onsets, strict=True)
    return [replace(part, onsets=float(n), contact_time=share * part.duration * (n > 0)) for part, n in pairs]


@pytest.mark.parametrize(
    ("turns", "onsets", "kind"),
    [
        ([-8.0] * 8, [1] + 7 * [0], Kind.TRANSIENT),  # one touch, and a free vibration that turns backward
        ([-8.0] * 8, [9] + 7 * [0], Kind.TRANSIENT),  # it bounces, and then no more
        ([-8.0] * 8, 5 * [0] + [9, 9, 9], Kind.TRANSIENT),  # it begins late
        ([-8.0] * 8, [9, 9, 0, 0, 0, 0, 9, 9], Kind.BOUNCING),
        ([-8.0] * 8, [9] * 8, Kind.BOUNCING),
        ([-3.5], [1], Kind.TRANSIENT),
        ([-3.5], [2], Kind.TRANSIENT),
        ([-3.5], [3], Kind.BOUNCING),
        ([6.25] * 8, [1] + 7 * [0], Kind.TRANSIENT),
        ([0.1, -0.1] * 4, [0, 1] * 4, Kind.PARTIAL_RUB),
    ],
)
def test_contact_that_does_not_repeat_itself_is_no_whirl_and_no_rub(turns, onsets, kind):
    shaft = SPEED * DURATION if len(turns) > 1 else 3.0
    assert motion_of(touched(turns, onsets), shaft, GAP).kind == kind


def test_a_long_contact_repeats_itself_with_one_touch():
    assert motion_of(touched([-3.5], [1], share=0.6), 3.0, GAP).kind == Kind.BOUNCING
    assert motion_of(touched([-3.5], [1], share=0.4), 3.0, GAP).kind == Kind.TRANSIENT


@pytest.mark.parametrize(("share", "kind"), [(0.4, Kind.PARTIAL_RUB), (0.6, Kind.FORWARD_WHIRL), (1.0, Kind.FORWARD_WHIRL)])
def test_where_something_feeds_it_a_whirl_may_bounce_forward(share, kind):
    assert motion_of(parts([7.0] * 8, share=share), SPEED * DURATION, GAP, driven=True).kind == kind
    assert motion_of(parts([6.25] * 8, share=0.6), SPEED * DURATION, GAP, driven=True).kind == Kind.PARTIAL_RUB  # the shaft's


def test_against_the_spin_is_backward_whichever_way_the_shaft_turns():
    own = parts([-8.0] * 8)
    assert motion_of(own, SPEED, GAP).kind == Kind.SLIDING
    assert motion_of(own, -SPEED, GAP).kind == Kind.FORWARD_WHIRL
    assert motion_of(parts([8.0] * 8), -SPEED, GAP).kind == Kind.SLIDING
    assert motion_of(own, SPEED, GAP).frequency == pytest.approx(-64.0)


def test_too_short_a_stretch_is_not_resolved_and_says_why():
    motion = motion_of(parts([0.5] * 4), 2.0, GAP)
    assert motion.kind == Kind.NOT_RESOLVED and motion.why == "2.0 turns: too short, run it longer"
    assert motion_of(parts([0.5] * 4), 2.0, GAP, diverged=True).kind == Kind.RUNNING_AWAY
