"""Systems with several contacts, and their equations written anew from docs/users/physics.md: dense matrices, a force each."""

from dataclasses import replace

import numpy as np

from rsc.system.system import ContactLaw, SystemContact
from systems import make_system, random_body


def with_contacts(system, contacts):
    """A System with other contacts; as `rsc.system.assemble` makes it, no body has the row of one of several."""
    alone = len(contacts) == 1
    rotor, stator = (
        replace(body, contact=getattr(contacts[0], name) if alone else np.full(body.n_coordinates, np.nan))
        for name, body in (("rotor", system.rotor), ("stator", system.stator))
    )
    return replace(system, rotor=rotor, stator=stator, contacts=tuple(contacts))


def random_several(rng, n=2, light=(-1.5, 0.0)):
    """A rotor of n to n + 2 coordinates with gyroscopics, n contacts with a stator of n to n + 1, all gaps and laws unequal."""
    n_rotor, n_stator = int(rng.integers(n, n + 3)), int(rng.integers(n, n + 2))
    rotor = random_body(rng, n_rotor, 10.0 ** rng.uniform(-2.5, -1.3))
    mass, damping, stiffness = random_body(rng, n_stator, 10.0 ** rng.uniform(-2.0, -0.7))
    share = 10.0 ** rng.uniform(*light)
    polar = np.diag(rng.uniform(0.0, 2.0, n_rotor) * np.diag(rotor[0]) * (np.arange(n_rotor) > 0))
    system = make_system((*rotor, polar), (share * mass, share * damping, share * stiffness), (0, 0, 0.1, 1e8))
    contacts = []
    for j in range(n):
        law = ContactLaw(10.0 ** rng.uniform(6.5, 8.5), 10.0 ** rng.uniform(1.0, 3.0), rng.uniform(0.05, 0.5))
        gap = 1e-3 * 10.0 ** rng.uniform(-0.5, 0.5)
        contacts.append(SystemContact(law, gap, np.eye(n_rotor)[j], np.eye(n_stator)[j], name=f"c{j}"))
    return with_contacts(system, contacts)


def dense(system, Psi, Omega):
    """A(Psi) of rotor and stator, (N + M, N + M), term by term, and the rows l_j (n, N + M)."""
    n, m = system.n_rotor, system.n_stator
    A = np.zeros((n + m, n + m), complex)
    for part, body, speed in ((slice(0, n), system.rotor, Omega), (slice(n, n + m), system.stator, 0.0)):
        damping = body.damping - 1j * speed * body.gyroscopic
        A[part, part] = body.stiffness + 1j * Psi * damping - Psi**2 * body.mass
    return A, np.array([[*contact.rotor, *(-contact.stator)] for contact in system.contacts])


def left_over(system, Psi, Omega, forces, angles):
    """Largest error of the equations of motion of a whirl, over the largest contact force: forces (n,) N, 0 where a contact is
    not pressed, at angles (n,) rad of its deflection, and that deflection against s + N/k, over the gap."""
    A, rows = dense(system, Psi, Omega)
    push = sum(
        (1.0 + 1j * contact.law.friction) * force * np.exp(1j * angle) * row
        for contact, force, angle, row in zip(system.contacts, forces, angles, rows, strict=True)
    )
    x = np.linalg.solve(A, -push)
    d = rows @ x
    errors = [
        abs(own - (contact.gap + force / contact.law.stiffness) * np.exp(1j * angle)) / contact.gap
        for own, contact, force, angle in zip(d, system.contacts, forces, angles, strict=True) if force > 0.0
    ]  # fmt: skip
    return x, max(errors)
