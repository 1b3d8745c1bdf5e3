"""The full finite-element machine of a scene as a `Witness`, without reduction and kernel."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from rsc.machine.model.contact import body_of
from rsc.system.assemble import assemble
from witness import Witness

TWO_PI = 2.0 * np.pi


class FullMachine(Witness):
    """A scene's rotor before its reduction; model: with or without bearings; turned: rad, angle of the shaft at time 0."""

    rtol, atol = 1e-9, 1e-13

    def __init__(self, scene, model, places, at_nodes, turned=0.0):
        super().__init__(scene)
        speed = max(scene.drive.speed)
        body = body_of(model, places, observers=[], speed=speed, **at_nodes)
        unbalance = body.unbalance.sum(axis=1)
        none = np.full(body.n_coordinates, np.nan)
        rotor = replace(body, unbalance=unbalance * np.exp(1j * turned), unbalance_euler=unbalance, contact=none)
        self.rows = body.contact
        contacts = tuple(replace(one, rotor=row) for one, row in zip(self.system.contacts, self.rows, strict=True))
        self.system, self.n = replace(assemble(scene), rotor=rotor, contacts=contacts, switched=()), body.n_coordinates

    def running(self, time=0.0):
        """Displacements and velocities (n,) of the steady motion by unbalance and load, without contact, at a time in s."""
        rotor, Omega = self.system.rotor, self.speed
        dynamic = rotor.stiffness - Omega**2 * (rotor.mass - rotor.gyroscopic) + 1j * Omega * rotor.damping
        turning = np.linalg.solve(dynamic, rotor.unbalance * Omega**2) * np.exp(1j * Omega * time)
        return np.linalg.solve(rotor.stiffness, rotor.load) + turning, 1j * Omega * turning

    def dropped(self, state, times):
        """Deflections (n_time, 2) at the contacts and speeds of the races in Hz from a state (displacements, velocities) on."""
        rest = (0j,) * self.system.n_stator
        self.start = SimpleNamespace(rotor=tuple(state[0]), rotor_velocity=tuple(state[1]), stator=rest, stator_velocity=rest)
        rotor, _, races = self.motion(times)
        return rotor @ self.rows.T, races / TWO_PI
