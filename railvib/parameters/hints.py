"""What an unknown key probably means: another convention, unit or table, or a slip of the pen."""

import difflib
import math
import re
from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from railvib.parameters.units import GRAVITY, KMH, unit_of

LONGEST_KEY = 100
"""Characters beyond which a key is not compared with those that are known."""


class Conversion(NamedTuple):
    """How a quantity of another convention becomes one that a table has."""

    key: str
    """Pattern of the other quantity's key, without regard to case."""
    target: str
    """The key to give instead; a group of the pattern may stand in it."""
    formula: str
    value: Callable[..., float]
    """The target's value, from that of the other quantity and those of `needs`."""
    needs: tuple[str, ...] = ()
    """Further keys of the table, as patterns."""


_POISSON = r"poiss?ons?(_?s)?(_(ratio|number))?|nu"
_DENSITY = r"density(_kg_m3)?"
_SHEAR_SPEED = r"shear_speed(_m_s)?"

CONVERSIONS = (
    Conversion(
        _POISSON,
        "dilatational_speed_m_s",
        "c_p = c_s sqrt((2 - 2 nu) / (1 - 2 nu))",
        lambda nu, shear_speed: shear_speed * math.sqrt((2.0 - 2.0 * nu) / (1.0 - 2.0 * nu)),
        (_SHEAR_SPEED,),
    ),
    Conversion(
        r"(\w+_)?damping(?:_ratio)?_percent",
        r"\1loss_factor",
        "eta = 2 D / 100 of a damping ratio D in percent",
        lambda percent: 0.02 * percent,
    ),
    Conversion(
        r"(\w+_)?(?:damping(?:_ratio)?|zeta|xi|d)",
        r"\1loss_factor",
        "eta = 2 D of a damping ratio D",
        lambda ratio: 2.0 * ratio,
    ),
    Conversion(r"quality(_factor)?|q_?s?", "loss_factor", "eta = 1 / Q", lambda quality: 1.0 / quality),
    Conversion(
        r"(young'?s?|elastic(ity)?|e)(_?s)?(_modulus)?(_pa)?|modulus_of_elasticity(_pa)?",
        "shear_speed_m_s",
        "c_s = sqrt(E / (2 (1 + nu) rho))",
        lambda modulus, nu, density: math.sqrt(modulus / (2.0 * (1.0 + nu) * density)),
        (_POISSON, _DENSITY),
    ),
    Conversion(
        r"shear_modulus(_pa)?|g_?(max|0)?(_pa)?",
        "shear_speed_m_s",
        "c_s = sqrt(G / rho)",
        lambda modulus, density: math.sqrt(modulus / density),
        (_DENSITY,),
    ),
    Conversion(
        r"(constrained|oedometric|p_wave)_modulus(_pa)?",
        "dilatational_speed_m_s",
        "c_p = sqrt(M / rho)",
        lambda modulus, density: math.sqrt(modulus / density),
        (_DENSITY,),
    ),
    Conversion(
        r"bulk_modulus(_pa)?",
        "dilatational_speed_m_s",
        "c_p = sqrt(K / rho + 4/3 c_s^2)",
        lambda modulus, density, shear_speed: math.sqrt(modulus / density + 4.0 / 3.0 * shear_speed**2),
        (_DENSITY, _SHEAR_SPEED),
    ),
    Conversion(
        r"(shear|s)_wave_(speed|velocity)(_m_s)?|[vc]_?s(_m_s)?",
        "shear_speed_m_s",
        "the same quantity",
        float,
    ),
    Conversion(
        r"(compression(al)?|p)_(wave_)?(speed|velocity)(_m_s)?|[vc]_?p(_m_s)?",
        "dilatational_speed_m_s",
        "the same quantity",
        float,
    ),
    Conversion(
        r"(unit|specific)_weight(_kn_m3)?",
        "density_kg_m3",
        "rho = 1000 gamma / 9.81 of a unit weight gamma in kN/m³",
        lambda weight: 1000.0 * weight / GRAVITY,
    ),
    Conversion(r"(speeds?|velocity)_m_s", "speed_kmh", "3.6 v of a speed in m/s", lambda v: KMH * v),
    Conversion(r"axle_(load|mass)_kg", "axle_load_n", "9.81 m of a mass in kg", lambda mass: GRAVITY * mass),
)
"""In the order in which they are tried."""

MULTIPLES = {
    "_mm": ("_m", 1e-3),
    "_cm": ("_m", 1e-2),
    "_km": ("_m", 1e3),
    "_km_s": ("_m_s", 1e3),
    "_g_cm3": ("_kg_m3", 1e3),
    "_t_m3": ("_kg_m3", 1e3),
    "_t": ("_kg", 1e3),
    "_t_m": ("_kg_m", 1e3),
    "_kn": ("_n", 1e3),
    "_kn_m": ("_n_m", 1e3),
    "_kn_mm": ("_n_m", 1e6),
    "_mn_m": ("_n_m", 1e6),
    "_kn_m2": ("_n_m2", 1e3),
    "_mn_m2": ("_n_m2", 1e6),
    "_kn_s_m": ("_n_s_m", 1e3),
    "_km_h": ("_kmh", 1.0),
    "_kph": ("_kmh", 1.0),
    "_mph": ("_kmh", 1.609344),
}
"""Endings of keys in other units: the ending to use, and what to multiply with."""


def hint(key: str, values: Mapping[str, Any], known: Collection[str], places: Mapping[str, str]) -> str:
    """Return what to write instead of a key that a table does not know.

    Parameters
    ----------
    key
        The unknown key.
    values
        All of the table; a conversion is worked out where they have what it takes.
    known
        The keys of the table.
    places
        Other tables by the keys that they have.
    """
    unknown = f"known are {', '.join(sorted(known))}"
    if len(key) > LONGEST_KEY:
        return unknown
    for conversion in CONVERSIONS:
        match = re.fullmatch(conversion.key, key, re.IGNORECASE)
        if match and (target := match.expand(conversion.target)) in known:
            value = _convert(conversion, values[key], values)
            return f"give {target}{_assignment(value, target)} ({conversion.formula})"
    for ending, (replacement, factor) in MULTIPLES.items():
        target = key.lower().removesuffix(ending) + replacement
        if key.lower().endswith(ending) and target in known:
            value = factor * values[key] if _is_number(values[key]) else None
            return f"give {target}{_assignment(value, target)} ({factor:g} {key})"
    if key in places:
        return f"it is a key of {places[key]}"
    nearest = difflib.get_close_matches(key, known, n=1, cutoff=0.6)
    return f"did you mean {nearest[0]}?" if nearest else unknown


def _convert(conversion: Conversion, value: Any, values: Mapping[str, Any]) -> float | None:
    """Return the value of a conversion where the table has the numbers for it, and they are possible."""
    numbers = [value]
    for pattern in conversion.needs:
        numbers += [values[key] for key in values if re.fullmatch(pattern, key, re.IGNORECASE)][:1]
    if len(numbers) <= len(conversion.needs) or not all(map(_is_number, numbers)):
        return None
    try:
        return conversion.value(*numbers)
    except (ValueError, ZeroDivisionError, OverflowError):
        return None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _assignment(value: float | None, key: str) -> str:
    return "" if value is None else f" = {value:.6g} {unit_of(key)}".rstrip()
