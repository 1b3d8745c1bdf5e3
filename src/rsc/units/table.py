"""The table of units: names, and factors to kg, m, s, A and rad.

Symbols of fewer than four letters are looked up in this table only, since elsewhere they are ambiguous ("mil" is also an angle in
artillery, "c" the speed of light). pint, which takes half a second to load, is used for spelled-out words only.
"""

from decimal import Decimal
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459")


class Unit(NamedTuple):
    """A unit as a factor and the powers of kg, m, s, A and rad."""

    factor: Fraction
    powers: tuple[int, ...]

    def times(self, other: "Unit", power: int) -> "Unit":
        """Product of this unit and a power of another one."""
        powers = tuple(mine + power * theirs for mine, theirs in zip(self.powers, other.powers, strict=True))
        return Unit(self.factor * other.factor**power, powers) 


ONE = Unit(Fraction(1), (0, 0, 0, 0, 0))
_MASS, _LENGTH, _TIME, _ANGLE = (1, 0, 0, 0, 0), (0, 1, 0, 0, 0), (0, 0, 1, 0, 0), (0, 0, 0, 0, 1)
_FORCE, _PRESSURE, _FREQUENCY, _VOLTAGE = (1, 1, -2, 0, 0), (1, -1, -2, 0, 0), (0, 0, -1, 0, 1), (1, 2, -3, -1, 0)
_POUND, _GRAVITY = Fraction("0.45359237"), Fraction("9.80665")

# quantity -> (powers, {synonymous names: factor}); source of the table in docs/users/scene.md
GROUPS: dict[str, tuple[tuple[int, int, int, int, int], dict[str, str | Fraction]]] = {
    "length": (
        _LENGTH,
        {"m": "1", "dm": "0.1", "cm": "0.01", "mm": "0.001", "um micron microns": "1e-6", "nm": "1e-9", "km": "1000",
         "in inch inches": "0.0254", "mil mils thou": "0.0000254", "uin": "2.54e-8", "ft foot feet": "0.3048"},
    ),
    "mass": (
        _MASS,
        {"kg": "1", "g": "0.001", "mg": "1e-6", "t": "1000", "lb lbs lbm": _POUND, "oz": _POUND / 16,
         "slug slugs": _POUND * _GRAVITY / Fraction("0.3048")},
    ),
    "time": (_TIME, {"s sec": "1", "ms msec": "0.001", "us usec": "1e-6", "ns": "1e-9", "min": "60", "h hr": "3600"}),
    "force": (
        _FORCE,
        {"N": "1", "mN": "0.001", "daN": "10", "kN": "1000", "MN": "1e6", "GN": "1e9", "lbf": _POUND * _GRAVITY,
         "ozf": _POUND * _GRAVITY / 16, "kip kips": 1000 * _POUND * _GRAVITY, "kgf kp": _GRAVITY},
    ),
    "pressure": (
        _PRESSURE,
        {"Pa": "1", "kPa": "1000", "MPa": "1e6", "GPa": "1e9", "bar": "1e5",
         "psi": _POUND * _GRAVITY / Fraction("0.0254") ** 2},
    ),
    "angle": (
        _ANGLE,
        {"rad": "1", "mrad": "0.001", "urad": "1e-6", "deg degree degrees °": PI / 180,
         "turn turns rev revs revolution revolutions r U cycle cycles": 2 * PI},
    ),
    "frequency, in turns": (
        _FREQUENCY,
        {"Hz hertz": 2 * PI, "mHz": 2 * PI / 1000, "kHz": 2000 * PI, "MHz": 2_000_000 * PI, "cps": 2 * PI,
         "rpm RPM cpm CPM Upm": 2 * PI / 60, "krpm": 2000 * PI / 60},
    ),
    "voltage": (_VOLTAGE, {"V volt volts": "1", "mV": "0.001", "uV": "1e-6", "kV": "1000"}),
    "velocity": ((0, 1, -1, 0, 0), {"ips": "0.0254"}),
    "share": ((0, 0, 0, 0, 0), {"% percent": "0.01"}),
}  # fmt: skip
UNITS = {
    name: Unit(Fraction(factor), powers)
    for powers, named in GROUPS.values()
    for names, factor in named.items()
    for name in names.split()
}
# products usually written without a sign; "Nms" is N m s, never N ms
TOGETHER = {
    **{f"{p}Nm": f"{p}N m" for p in ("", "m", "k", "M")},
    **{f"{p}Ns": f"{p}N s" for p in ("", "k", "M")},
    **{f"{p}Nms": f"{p}N m s" for p in ("", "k")},
    "Nmm": "N mm", "Ncm": "N cm", "kNmm": "kN mm", "kgm": "kg m", "kgmm": "kg mm", "kgcm": "kg cm", "gmm": "g mm", "gcm": "g cm",
    "ozin": "oz in", "lbfs": "lbf s", "lbfin": "lbf in", "lbfft": "lbf ft",
}  # fmt: skip
# symbols with a special meaning in a single dimension
ALONE = {("g", "acceleration"): Unit(_GRAVITY, (0, 1, -2, 0, 0))}
# ambiguous symbol -> what to write instead
AMBIGUOUS = {
    "ton": '"t" for 1000 kg, "short_ton" or "long_ton"', "tons": '"t" for 1000 kg, "short_ton" or "long_ton"',
    "rps": '"rev/s" or "rad/s"', "gm": '"g" or "g m"', "gr": '"g" or "grain"', "u": '"um"', "mu": '"um"', "k": '"kN", "kHz", ...',
    "point": '"um" or "mm"', "points": '"um" or "mm"', "pica": '"um" or "mm"', "count": '"1"', "counts": '"1"',
}  # fmt: skip


def known(name: str) -> Unit | None:
    """The unit of a name; None if neither the table nor (for spelled-out words) pint knows it."""
    if name in UNITS:
        return UNITS[name]
    return _of_pint(name) if len(name) > 3 and name.islower() and name.isascii() else None


@cache
def _of_pint(name: str) -> Unit | None:
    import pint

    registry = _registry()
    try:
        factor, root = registry.get_root_units(registry.parse_units(name))
    except (pint.errors.PintError, AttributeError, ValueError, TypeError):
        return None
    powers = {str(base): power for base, power in root._units.items()}
    if any(power != int(power) for power in powers.values()):
        return None
    made = tuple(int(powers.pop(base, 0)) for base in ("gram", "meter", "second", "ampere", "radian"))
    return None if powers else Unit(Fraction(Decimal(factor)) / 1000 ** made[0], made)


@cache
def _registry() -> Any:
    """pint's unit registry, created once; in decimal arithmetic, which makes metric prefixes exact."""
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)
