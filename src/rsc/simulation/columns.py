"""Matrices that stay full in real modes, as the kernel multiplies them: column by column, on cache lines.

Damping beside its diagonal, gyroscopic terms, rotating damping, skew and anisotropic springs and dampers, and what of them
changes with the speed or as bearings are switched off.
"""

import numpy as np
import scipy

from rsc.simulation.following import additions, changes, lines_between, of_bearings
from rsc.simulation.lines import on_lines
from rsc.simulation.real_modes import ROUNDING


def damping_of(system, rotor, stator, by_component):
    """Diagonal (n,) and columns of the rest of M^-1 B in modes, including skew and anisotropic damping."""
    full = _block_diagonal(
        rotor.shape.T @ system.rotor.damping @ rotor.shape / rotor.reference_mass,
        stator.shape.T @ system.stator.damping @ stator.shape / stator.reference_mass,
    )
    diagonal = full.diagonal().copy()
    np.fill_diagonal(full, 0.0)
    if full.any():
        size = np.sqrt(np.abs(diagonal[:, None] * diagonal))
        full[np.abs(full) <= ROUNDING * np.maximum(size, np.abs(diagonal).max())] = 0.0
    if by_component:
        skew, anisotropic = _directed(system, "damping", rotor, stator)
        columns = _by_component(skew - full, anisotropic)
        return diagonal, columns if columns.any() else ()
    return diagonal, _columns(-full)


def _directed(system, kind, rotor, stator):
    """(linear, conjugate), complex (n, n): linear r + conjugate conj(r) is the force per mass in modes due to skew and
    anisotropic "stiffness", or due to the "damping" for r'."""
    parts = {}
    for name in ("skew", "anisotropic"):
        matrices = [getattr(body, f"{name}_{kind}") for body in system.bodies]
        parts[name] = scipy.linalg.block_diag(
            *(
                np.zeros_like(modes.shape) if matrix is None else modes.shape.T @ matrix @ modes.shape / modes.reference_mass
                for matrix, modes in zip(matrices, (rotor, stator), strict=True)
            )
        )
    return -1j * parts["skew"], -parts["anisotropic"]


def _by_component(linear, conjugate):
    """The matrix x -> linear x + conjugate conj(x) for `vec.times_components`, (2n, 2n)."""
    same = np.stack([linear.real + conjugate.real, linear.real - conjugate.real])  # y of y, z of z
    other = np.stack([conjugate.imag - linear.imag, conjugate.imag + linear.imag])  # y of z, z of y
    return on_lines(np.concatenate([part.transpose(2, 1, 0).reshape(len(linear), -1) for part in (same, other)]))


def same_all_round(damping):
    """Matrices of a model without skew and anisotropic stiffness, with this damping."""
    return {"damping_columns": damping, "stiffness_columns": (), "following_stiffness": (), "following_damping": ()}


def directed_columns(full, system, damping, rotor, stator):
    """Matrices of a model by component, including speed-dependent ones; system: the `reference` of the full one."""
    stiffness = _by_component(*_directed(system, "stiffness", rotor, stator))
    made = same_all_round(damping) | {"stiffness_columns": stiffness}
    if not changes(full):
        return made
    following = _following(full, system, {"stiffness": stiffness, "damping": damping}, rotor)
    made |= {"stiffness_columns": (), "following_stiffness": following[0], "following_damping": following[1]}
    return made | ({"damping_columns": ()} if len(following[1]) else {})


def _following(full, system, columns, rotor):
    """[stiffness, damping] matrices of coefficients that change (`Model`), with the constant ones included; damping () if it is
    constant. system: the `reference` of the full one, columns: its matrices."""
    made, more = [], system.n_stator
    for kind in ("stiffness", "damping"):
        knots = _each_by_component(additions(full, system.rotor, kind, rotor), more) if len(full.knot_speed) else np.zeros(0)
        bearings = _each_by_component(of_bearings(full, kind, rotor), more) if full.switched else np.zeros(0)
        if kind == "damping" and not (knots.any() or bearings.any()):
            made.append(())
            continue
        constant = columns[kind] if len(columns[kind]) else 0.0
        width = 2 * (system.n_rotor + more)
        if len(knots):
            lines = lines_between(full.knot_speed, knots + constant)
        else:
            lines = np.zeros((1, 2, width, width))
            lines[0, 0] += constant
        for part in bearings[::-1]:  # those that are switched off later are still there
            earlier = lines[: len(full.knot_speed) + 1].copy()
            earlier[:, 0] += part
            lines = np.concatenate([earlier, lines])
        made.append(on_lines(lines.reshape(-1, lines.shape[-1])).reshape(lines.shape))
    return made


def _each_by_component(parts, more):
    """`_by_component` of pairs of matrices (k, N, N), with `more` coordinates of the stator."""
    pads = ((0, 0), (0, more), (0, more))
    return np.array([_by_component(*pair) for pair in zip(*(np.pad(part, pads) for part in parts), strict=True)])


def rotor_columns(system, matrix, rotor):
    """Columns of a rotor matrix per mass, in modes; () if zero or None."""
    if matrix is None or not matrix.any():
        return ()
    matrix = rotor.shape.T @ matrix @ rotor.shape / rotor.reference_mass
    return _columns(_block_diagonal(matrix, np.zeros_like(system.stator.mass)))


def _block_diagonal(first, second):
    """Two square matrices along the diagonal; SciPy's function takes ten times as long, noticeable in ensembles of small
    scenes."""
    n, m = first.shape[0], second.shape[0]
    matrix = np.zeros((n + m, n + m))
    matrix[:n, :n], matrix[n:, n:] = first, second
    return matrix


def _columns(matrix):
    """Columns with every entry twice, (n, 2n); () for a zero matrix."""
    if not matrix.any():
        return ()
    return on_lines(matrix.T.repeat(2, axis=1))
