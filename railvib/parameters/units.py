"""Units at the edge: inside all is SI, and the name of a key ends with the unit of its value."""

KMH = 3.6
"""km/h per m/s."""

GRAVITY = 9.81
"""m/s²; axle loads that are not given follow from the masses by it."""

UNITS = {
    "bending_stiffness_n_m2": "N·m²",
    "inertia_kg_m2": "kg·m²",
    "_m_s": "m/s",
    "_kg_m3": "kg/m³",
    "_kg_m": "kg/m",
    "_kg": "kg",
    "_n_s_m": "N·s/m",
    "_n_m2": "N/m²",
    "_n_m": "N/m",
    "_n": "N",
    "_m3": "m³",
    "_db": "dB",
    "_hz": "Hz",
    "_kmh": "km/h",
    "_minutes": "min",
    "_gb": "GB",
    "_m": "m",
}
"""Units by the endings of keys, a longer ending before the shorter one that it contains."""


def unit_of(key: str) -> str:
    """Return the unit that a key names by its ending, nothing for pure numbers and names."""
    return next((unit for ending, unit in UNITS.items() if key.endswith(ending)), "")
