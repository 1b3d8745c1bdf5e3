"""`rsc.equations`: the equations of motion of a scene for an integrator of your own."""

import sys
from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rsc.arguments import SCENE, takes
from rsc.errors import SolverError
from rsc.scene.scene import Scene
from rsc.study.equations import motion
from rsc.study.equations.motion import CLIPPED, CLOSING, OPEN, OPENING, PRESSED, SLIDING, Constants
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble
from rsc.system.system import ContactLaw, System

VELOCITY_SCALE = 300.0  # 1/s: a velocity may err by this times what a displacement may
States = NDArray[np.int64]
Real = NDArray[np.float64]


class Entry(NamedTuple):
    """One entry of the state: "rotor 0 y", its unit, and whether it is a velocity."""

    name: str
    unit: str
    velocity: bool


class Switch:
    """A function of t and y that is zero where the state of a contact ends; as scipy's `solve_ivp` wants its events.

    terminal : True; direction : -1.0 or 1.0, of the crossing; contact : number; to : what the state becomes
    """

    terminal = True

    def __init__(self, value: Callable[[float, Real], float], direction: float, after: Callable[[float, Real], States]) -> None:
        self._value, self.direction, self._after = value, direction, after

    def __call__(self, t: float, y: Real, *_: object) -> float:
        # an exact zero is where the state before ended: solve_ivp would find it again, and no run could leave it
        return self._value(t, y) or -self.direction * sys.float_info.min

    def after(self, t: float, y: Real) -> States:
        """(n_contacts, 2) the states behind it."""
        return self._after(t, y)


class Equations:
    """Equations of motion of a scene, y' = rhs(t, y), with what an integrator may want to know of them.

    scene : Scene; layout : tuple of Entry, what the numbers of y are; start : (n_state,) y at t = 0; duration : s
    scale : (n_state,) what an entry may err by at a relative tolerance of 1: the gap, and of velocities 300/s times it

    The contact makes the right-hand side continuous with kinks: it is smooth while no contact changes its state. `rhs(t, y)`
    takes the states from y; `rhs(t, y, states)` holds them and continues the forces smoothly, until one of `switches(states)`
    changes its sign.
    """

    def __init__(self, scene: Scene) -> None:
        system = assemble(scene)
        _refuse_unknown(scene, system)
        self.scene, self.constants = scene, _constants(system)
        self.duration = float(scene.drive.duration)
        bodies = [f"rotor {i}" for i in range(system.n_rotor)] + [f"stator {i}" for i in range(system.n_stator)]
        places = [(f"{body} {axis}", axis) for axis in "yz" for body in bodies]
        self.layout = tuple(
            Entry(f"{name}{' velocity' * fast}", "m/s" if fast else "m", bool(fast)) for fast in (0, 1) for name, _ in places
        )
        first = initial_state(scene, system)
        parts = np.concatenate([first.rotor, first.stator]), np.concatenate([first.rotor_velocity, first.stator_velocity])
        self.start = np.concatenate([part for own in parts for part in (own.real, own.imag)])
        gap = min(contact.gap for contact in system.contacts)
        self.scale = gap * np.where([entry.velocity for entry in self.layout], VELOCITY_SCALE, 1.0)
        self._system = system

    def __repr__(self) -> str:
        return f"Equations of {self.scene.title[:60]!r}: {len(self.layout)} state variables, {len(self.constants.gap)} contacts"

    def rhs(self, t: float, y: Real, states: States | None = None) -> Real:
        """y' (n_state,) at t in s, in NumPy; with `states` as if the contacts stayed in them."""
        return motion.slope(t, y, self.states(t, y) if states is None else states, self.constants)

    def states(self, t: float, y: Real) -> States:
        """(n_contacts, 2): OPEN 0, CLOSING 1, OPENING 2 (with the damper) or CLIPPED 3 (the damper would pull, and lets go); and
        -1 or 1 where the contact slides that way, 0 within the slip velocity, and with one-sided friction."""
        return motion.states_at(t, y, self.constants)

    def switches(self, states: States) -> list[Switch]:
        """Where these states end: `events` of `scipy.integrate.solve_ivp`."""
        return [switch for c in range(len(states)) for switch in self._switches_of(c, states)]

    def _switches_of(self, c: int, states: States) -> list[Switch]:
        delta, delta_dot, force, slip = range(4)
        let_go = (force, 0.0, -1.0, PRESSED, CLIPPED) if self.constants.damper[c] > 0.0 else (delta, 0.0, 1.0, PRESSED, OPEN)
        ends = {
            OPEN: [(delta, 0.0, -1.0, PRESSED, CLOSING)],
            CLOSING: [(delta_dot, 0.0, 1.0, PRESSED, OPENING)],
            OPENING: [(delta_dot, 0.0, -1.0, PRESSED, CLOSING), let_go],
            CLIPPED: [(delta, 0.0, 1.0, PRESSED, OPEN), (force, 0.0, 1.0, PRESSED, OPENING)],
        }[int(states[c, PRESSED])]
        limit = self.constants.slip_velocity[c]
        if limit > 0.0 and states[c, PRESSED] != OPEN:
            sliding = int(states[c, SLIDING])
            if sliding >= 0:
                ends = [*ends, (slip, limit, -1.0 if sliding else 1.0, SLIDING, 0 if sliding else 1)]
            if sliding <= 0:
                ends = [*ends, (slip, -limit, 1.0 if sliding else -1.0, SLIDING, 0 if sliding else -1)]
        return [self._switch(c, states, *own) for own in ends]

    def _switch(self, c: int, states: States, which: int, level: float, direction: float, column: int, to: int) -> Switch:
        def value(t: float, y: Real) -> float:
            angle, omega, _ = motion.turned(t, self.constants)
            return float(motion.quantities(c, y, angle, omega, self.constants)[which] - level)

        def after(t: float, y: Real) -> States:
            new = states.copy()
            new[c, column] = to
            if column == PRESSED and states[c, PRESSED] == OPEN:
                new[c, SLIDING] = self.states(t, y)[c, SLIDING]
            return new

        return Switch(value, direction, after)

    def jacobian(self, t: float, y: Real, states: States | None = None) -> Real:
        """(n_state, n_state) derivative of `rhs` by y, in closed form."""
        p, states = self.constants, self.states(t, y) if states is None else states
        n = p.n
        angle, omega, _ = motion.turned(t, p)
        out = np.zeros((4 * n, 4 * n))
        out[: 2 * n, 2 * n :] = np.eye(2 * n)
        out[2 * n :, : 2 * n] = omega * p.turning_stiffness - p.stiffness
        out[2 * n :, 2 * n :] = omega * p.turning_damping - p.damping
        for c in range(len(p.gap)):
            by = np.kron(motion.contact_jacobian(c, y, angle, omega, states, p), p.rows[c])
            out[2 * n :] -= np.kron(np.eye(2), p.per_force[c][:, None]) @ by
        return out

    def energy(self, t: float, y: Real) -> float:
        """Kinetic energy, and potential energy of the bodies' springs and of the pressed contacts, in J."""
        p, n = self.constants, self.constants.n
        total = 0.5 * sum(
            float(part @ matrix @ part)
            for matrix, own in ((self._mass, y[2 * n :]), (self._spring, y[: 2 * n]))
            for part in ([own[:n], own[n:]] if matrix.shape[0] == n else [own])
        )
        angle, omega, _ = motion.turned(t, p)
        for c in range(len(p.gap)):
            delta = motion.quantities(c, y, angle, omega, p)[0]
            total += 0.5 * float(p.spring[c]) * min(float(delta), 0.0) ** 2
        return total

    @cached_property
    def longest_step(self) -> float:
        """A fifth of the shortest period of a body against the spring of a contact, in s: within longer steps a pair of
        switches may lie, which an integrator that looks for changes of sign between its steps does not see."""
        p = self.constants
        square = p.spring * np.sum(p.rows * p.per_force, axis=1)
        return float(2.0 * np.pi / np.sqrt(square.max()) / 5.0)

    @cached_property
    def _mass(self) -> Real:
        return _both(self._system, "mass").real

    @cached_property
    def _spring(self) -> Real:
        return _real(_both(self._system, "stiffness"), _both(self._system, "anisotropic_stiffness"))

    def displacements(self, y: Any) -> NDArray[np.complex128]:
        """(..., n_rotor + n_stator) complex m, of states (..., n_state)."""
        y, n = np.asarray(y), self.constants.n
        return y[..., :n] + 1j * y[..., n : 2 * n]

    @cached_property
    def compiled(self) -> Any:
        """`f(t, y)` as a function of Numba, to be called from other compiled functions; compiled when first asked for."""
        import numba

        turned, relative = numba.njit(motion.turned), numba.njit(motion.relative)
        own = {"turned": turned, "relative": relative, "quantities": _with(motion.quantities, relative=relative)}
        states_at, force = _with(motion.states_at, **own), _with(motion.contact_force, **own)
        slope, p = _with(motion.slope, turned=turned, contact_force=force), self.constants

        @numba.njit
        def rhs(t, y):  # type: ignore[no-untyped-def]
            return slope(t, y, states_at(t, y, p), p)

        return rhs

    @cached_property
    def callback(self) -> Any:
        """The compiled right-hand side as a function of C, ``void f(double t, const double *y, double *dy)``: its `address` is
        what integrators in C, C++ and Fortran take."""
        import numba
        from numba import carray, types

        f, size = self.compiled, len(self.layout)

        @numba.cfunc(types.void(types.float64, types.CPointer(types.float64), types.CPointer(types.float64)))
        def call(t, y, dy):  # type: ignore[no-untyped-def]
            carray(dy, (size,))[:] = f(t, carray(y, (size,)))

        return call


@takes(scene=SCENE)
def equations(scene: Scene) -> Equations:
    """The equations of motion of a scene, for an integrator of your own.

    Parameters
    ----------
    scene : Scene
        With one contact or several, and a prescribed speed.

    Returns
    -------
    Equations
        Layout and units of the state, right-hand side in NumPy and compiled, states of the contacts and where they switch,
        Jacobian, energy.

    Raises
    ------
    SolverError
        The scene has what these equations leave out: a torque-limited drive, a race that turns, coefficients that follow the
        rotor speed, bearings that are switched off, or a contact law of another kind.
    SceneError
        Its start does not exist.

    Examples
    --------
    >>> equations = rsc.equations(rsc.load_scene("laval.toml"))
    >>> [entry.name for entry in equations.layout]
    ['rotor 0 y', 'stator 0 y', ...]
    >>> equations.rhs(0.0, equations.start).shape
    (8,)
    """
    return Equations(scene)


def _refuse_unknown(scene: Scene, system: System) -> None:
    unknown = {
        "a drive with a torque": system.drive is not None,
        "a race that turns": any(contact.law.race_inertia is not None for contact in system.contacts),
        "coefficients that follow the rotor speed": system.rotor.knots is not None,
        "first-order states": system.n_states > 0,
        "bearings that are switched off": len(system.switched) > 0,
        "a contact law of another kind": any(type(contact.law) is not ContactLaw for contact in system.contacts),
    }
    left_out = [name for name, is_there in unknown.items() if is_there]
    if left_out:
        raise SolverError(f"rsc.equations does not have {' or '.join(left_out)}; rsc.simulate runs such a scene")


def _with(function: Any, **compiled: Any) -> Any:
    """A function compiled by Numba, which calls compiled ones in the place of those that its module has by these names."""
    import types

    import numba

    own = types.FunctionType(function.__code__, {**function.__globals__, **compiled}, function.__name__)
    return numba.njit(own)


def _both(system: System, name: str) -> NDArray[np.complex128]:
    """(n, n) the matrices of this name of rotor and stator, one below the other."""
    n, m = system.n_rotor, system.n_stator
    joined = np.zeros((n + m, n + m), complex)
    for body, place in ((system.rotor, slice(0, n)), (system.stator, slice(n, n + m))):
        own = getattr(body, name)
        if own is not None:
            joined[place, place] = own
    return joined


def _real(on: NDArray[np.complex128], on_conjugates: NDArray[np.complex128]) -> Real:
    """(2n, 2n) the real form of a matrix that acts on y + i z, and of one that acts on y - i z."""
    plus, minus = on + on_conjugates, on - on_conjugates
    return np.block([[plus.real, -minus.imag], [plus.imag, minus.real]])


def _constants(system: System) -> Constants:
    """The constants of a system."""
    inverse = np.linalg.inv(_both(system, "mass"))
    zero = np.zeros_like(inverse)
    terms = {name: inverse @ _both(system, name) for name in (
        "stiffness", "damping", "gyroscopic", "skew_stiffness", "skew_damping", "anisotropic_stiffness", "anisotropic_damping",
        "rotating_damping")}  # fmt: skip
    still = np.zeros(system.n_stator)
    time, speed = system.schedule_time, system.schedule_speed
    angle = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time) * (speed[1:] + speed[:-1]))])
    rows = np.array([np.concatenate([contact.rotor, -contact.stator]) for contact in system.contacts])
    load = inverse @ np.concatenate([system.rotor.load, still])
    laws = [contact.law for contact in system.contacts]
    return Constants(
        n=len(inverse),
        stiffness=_real(terms["stiffness"] + 1j * terms["skew_stiffness"], terms["anisotropic_stiffness"]),
        damping=_real(
            terms["damping"] + terms["rotating_damping"] + 1j * terms["skew_damping"], terms["anisotropic_damping"]
        ),
        turning_stiffness=_real(1j * terms["rotating_damping"], zero),
        turning_damping=_real(1j * terms["gyroscopic"], zero),
        unbalance=inverse @ np.concatenate([system.rotor.unbalance, still]),
        euler=inverse @ np.concatenate([system.rotor.unbalance_euler, still]),
        load=np.concatenate([load.real, load.imag]),
        time=np.ascontiguousarray(time, float),
        speed=np.ascontiguousarray(speed, float),
        angle=angle,
        rows=rows,
        per_force=np.ascontiguousarray((rows @ inverse.T).real),
        gap=np.array([float(contact.gap) for contact in system.contacts]),
        spring=np.array([float(law.stiffness) for law in laws]),
        damper=np.array([float(law.damping) for law in laws]),
        friction=np.array([float(law.friction) for law in laws]),
        radius=np.array([0.5 * (law.diameter or 0.0) for law in laws]),
        slip_velocity=np.array([0.0 if law.diameter is None else float(law.slip_velocity or 0.0) for law in laws]),
        ring=np.array([complex(contact.ring) for contact in system.contacts]),
        offset=np.array([complex(contact.offset) for contact in system.contacts]),
        sense=system.sense,
    )
