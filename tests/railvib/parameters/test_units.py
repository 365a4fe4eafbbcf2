"""The unit of a key is the one that its name ends with."""

import pytest

from railvib.parameters.units import unit_of


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("shear_speed_m_s", "m/s"),
        ("density_kg_m3", "kg/m³"),
        ("thickness_m", "m"),
        ("rail_bending_stiffness_n_m2", "N·m²"),
        ("pad_stiffness_n_m2", "N/m²"),
        ("rail_mass_kg_m", "kg/m"),
        ("car_pitch_inertia_kg_m2", "kg·m²"),
        ("primary_damping_n_s_m", "N·s/m"),
        ("axle_load_n", "N"),
        ("car_mass_kg", "kg"),
        ("spectral_density_m3", "m³"),
        ("level_db", "dB"),
        ("maximum_hz", "Hz"),
        ("speed_kmh", "km/h"),
        ("walltime_minutes", "min"),
        ("loss_factor", ""),
        ("line_class", ""),
    ],
)
def test_unit_of_a_key(key, unit):
    assert unit_of(key) == unit
