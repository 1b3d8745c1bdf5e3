"""Features that a scene may lack: the questions by which `static` helpers select their code at compile time.

The field of an absent feature is (), whose type differs from that of any value, so each combination is compiled separately.
"""

from numba import types

from rsc.kernel.simd.static import question


def type_of(kind, name):
    """Type of a field of a named tuple, given the type of the tuple."""
    return kind[kind.fields.index(name)]


@question
def is_none(kind):
    """Whether a value is ()."""
    return isinstance(kind, types.BaseTuple) and not len(kind)


@question
def is_one(kind):
    """Whether a tuple has one member."""
    return len(kind) == 1


@question
def is_array(kind):
    """Whether a value is an array."""
    return isinstance(kind, types.Array)


@question
def is_driven(con):
    """Whether Constants have a torque-limited drive, whose speed is integrated."""
    return not is_none(type_of(con, "drive"))


@question
def flies(con):
    """Whether Constants have what flight needs."""
    return not is_none(type_of(con, "flight"))


@question
def is_coupled(con):
    """Whether Constants have full damping or gyroscopic matrices."""
    return not is_none(type_of(con, "columns"))


@question
def by_component(con):
    """Whether stiffness and damping act differently on y and z: skew or anisotropic."""
    return len(type_of(con, "columns")) > 2


@question
def has_race(contact):
    """Whether ContactConstants have a rotating inner race."""
    return not is_none(type_of(contact, "race"))


@question
def rotates(con):
    """Whether there is rotating damping."""
    return not is_none(type_of(con, "rotating"))


@question
def follows(con):
    """Whether there are speed-dependent coefficients."""
    return not is_none(type_of(con, "following"))


@question
def damping_follows(field):
    """Whether the damping of a `rhs.Field` is speed-dependent."""
    return len(type_of(field, "following")) > 2


@question
def has_states(con):
    """Whether there are first-order states."""
    return not is_none(type_of(con, "states"))


@question
def has_no_sums(work):
    """Whether `rhs.Powers` belong to one state and are not sums over the stages of a step."""
    return is_none(type_of(work, "drive"))
