"""What a scene has and has not: the questions by which `static` helpers choose their code while compiling.

A scene lacks a thing where its field is (), which is another type than any value; so each kind of scene has code of its own.
"""

from numba import types

from rsc.kernel.simd.static import question


def type_of(kind, name):
    """Type of a field of a named tuple, by the type of the tuple."""
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
    """Whether Constants have a drive, whose speed is integrated."""
    return not is_none(type_of(con, "drive"))


@question
def flies(con):
    """Whether Constants have what flight needs."""
    return not is_none(type_of(con, "flight"))


@question
def is_coupled(con):
    """Whether Constants have full matrices of damping or gyroscopics."""
    return not is_none(type_of(con, "columns"))


@question
def by_component(con):
    """Whether those of stiffness and damping act on y and z apart: skew or anisotropic."""
    return len(type_of(con, "columns")) > 2


@question
def rotates(con):
    """Whether there is rotating damping."""
    return not is_none(type_of(con, "rotating"))


@question
def follows(con):
    """Whether there are coefficients that follow the speed."""
    return not is_none(type_of(con, "following"))


@question
def damping_follows(field):
    """Whether the damping of a `rhs.Field` follows the speed."""
    return len(type_of(field, "following")) > 2


@question
def has_no_sums(work):
    """Whether `rhs.Powers` are those of one state, not sums over the stages of a step."""
    return is_none(type_of(work, "drive"))
