"""A contact law that the package does not have, F = k p (1 + h p/gap), added as CONTRIBUTING.md says and by nothing else."""

from dataclasses import dataclass, replace
from typing import NamedTuple

from rsc.kernel import springs
from rsc.simulation import pack
from rsc.system.system import ContactLaw


@dataclass(frozen=True, eq=False)
class Hardening(ContactLaw):
    """The pseudolinear law with a spring that gets harder."""

    hardening: float = 0.0  # h


class Stiffening(NamedTuple):
    """F = k p (1 + per_depth p) where pressed."""

    k: float  # N/m
    per_depth: float  # 1/m, h/gap


def _share(spring, place, gap):
    return spring.k * place.penetration * (1.0 + spring.per_depth * place.penetration) * place.inverse


def _power(spring, p_0, p_1):
    square, cube = p_0 * p_0 - p_1 * p_1, p_0 * p_0 * p_0 - p_1 * p_1 * p_1
    return spring.k * (0.5 * square + spring.per_depth / 3.0 * cube)


springs.ROOMS[Stiffening] = springs.Room(
    of=lambda law, gap: Stiffening(float(law.stiffness), float(law.hardening / gap)),
    times=lambda spring, factor: Stiffening(factor * spring.k, spring.per_depth),
    share=_share,
    switch=lambda spring, p: spring.k * p * (1.0 + spring.per_depth * max(p, 0.0)),
    slope=lambda spring, p: spring.k * (1.0 + 2.0 * spring.per_depth * max(p, 0.0)),
    power=_power,
    limit=lambda spring: spring.k,
)
pack.SPRINGS[Hardening] = Stiffening


def hardened(system, hardening):
    """The system with this law."""
    law = Hardening(**vars(system.law), hardening=hardening)
    return replace(system, contacts=(replace(system.contact, law=law),))
