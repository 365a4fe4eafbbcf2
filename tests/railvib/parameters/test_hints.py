"""Unknown keys: what the field calls a quantity otherwise, with the conversion where it can be worked out."""

import math

import pytest

from railvib.errors import InputError
from railvib.library import entry
from railvib.parameters.ground import Layer
from railvib.parameters.track import Track
from railvib.parameters.vehicle import Vehicle

SAND = {
    "density_kg_m3": 1800.0,
    "loss_factor": 0.1,
    "dilatational_speed_m_s": 400.0,
    "shear_speed_m_s": 200.0,
}
TRACK = dict(entry("track", "ballasted-paper").parameters)
VEHICLE = dict(entry("vehicle", "regina").parameters)


def given(model, table, without, **others):
    """Return what is said of keys that stand in the place of another."""
    with pytest.raises(InputError) as refusal:
        model(**{key: value for key, value in table.items() if key != without}, **others)
    return str(refusal.value)


@pytest.mark.parametrize(
    ("without", "others", "target", "formula"),
    [
        (
            "dilatational_speed_m_s",
            {"poisson_ratio": 0.3},
            f"dilatational_speed_m_s = {200 * math.sqrt(1.4 / 0.4):.6g} m/s",
            "c_p = c_s sqrt((2 - 2 nu) / (1 - 2 nu))",
        ),
        ("dilatational_speed_m_s", {"nu": 0.5}, "dilatational_speed_m_s (", "c_p = c_s"),
        ("dilatational_speed_m_s", {"poissons_ratio": "0.3"}, "dilatational_speed_m_s (", "c_p = c_s"),
        ("loss_factor", {"damping_ratio": 0.03}, "loss_factor = 0.06", "eta = 2 D"),
        ("loss_factor", {"damping_percent": 3}, "loss_factor = 0.06", "eta = 2 D / 100"),
        ("loss_factor", {"Q": 20}, "loss_factor = 0.05", "eta = 1 / Q"),
        (
            "shear_speed_m_s",
            {"youngs_modulus_pa": 187.2e6, "poisson_ratio": 0.3},
            "shear_speed_m_s = 200 m/s",
            "c_s = sqrt(E / (2 (1 + nu) rho))",
        ),
        ("shear_speed_m_s", {"youngs_modulus": 187.2e6}, "shear_speed_m_s (", "c_s = sqrt(E"),
        ("shear_speed_m_s", {"shear_modulus_pa": 72e6}, "shear_speed_m_s = 200 m/s", "c_s = sqrt(G / rho)"),
        ("shear_speed_m_s", {"vs": 200.0}, "shear_speed_m_s = 200 m/s", "the same quantity"),
        (
            "dilatational_speed_m_s",
            {"p_wave_velocity_m_s": 400},
            "dilatational_speed_m_s = 400 m/s",
            "the same",
        ),
        ("dilatational_speed_m_s", {"bulk_modulus_pa": 192e6}, "dilatational_speed_m_s = 400 m/s", "K / rho"),
        (
            "dilatational_speed_m_s",
            {"oedometric_modulus_pa": 288e6},
            "dilatational_speed_m_s = 400",
            "M / rho",
        ),
        ("density_kg_m3", {"density_g_cm3": 1.8}, "density_kg_m3 = 1800 kg/m³", "1000 density_g_cm3"),
        ("density_kg_m3", {"unit_weight_kn_m3": 17.658}, "density_kg_m3 = 1800 kg/m³", "unit weight"),
        ("thickness_m", {"thickness_mm": 300}, "thickness_m = 0.3 m", "0.001 thickness_mm"),
    ],
)
def test_a_layer_in_other_conventions(without, others, target, formula):
    key = next(key for key in others)
    message = given(Layer, SAND, without, **others)
    assert message.startswith(f"Layer.{key}: unknown key; give {target}")
    assert formula in message


@pytest.mark.parametrize(
    ("model", "table", "without", "key", "value", "target"),
    [
        (Track, TRACK, "pad_loss_factor", "pad_damping_ratio", 0.05, "pad_loss_factor = 0.1"),
        (Track, TRACK, "rail_loss_factor", "rail_damping", 0.005, "rail_loss_factor = 0.01"),
        (Track, TRACK, "pad_stiffness_n_m2", "pad_stiffness_mn_m2", 1000, "pad_stiffness_n_m2 = 1e+09 N/m²"),
        (Vehicle, VEHICLE, "axle_load_n", "axle_load_kg", 14e3, "axle_load_n = 137340 N"),
        (Vehicle, VEHICLE, "car_mass_kg", "car_mass_t", 40, "car_mass_kg = 40000 kg"),
        (
            Vehicle,
            VEHICLE,
            "primary_stiffness_n_m",
            "primary_stiffness_kn_mm",
            2.4,
            "primary_stiffness_n_m = 2.4e+06",
        ),
    ],
)
def test_a_track_or_a_vehicle_in_other_conventions(model, table, without, key, value, target):
    assert f".{key}: unknown key; give {target}" in given(model, table, without, **{key: value})


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("loss_faktor", "did you mean loss_factor?"),
        (
            "colour",
            "known are density_kg_m3, dilatational_speed_m_s, loss_factor, shear_speed_m_s, thickness_m",
        ),
        ("poisson_ratio", "give dilatational_speed_m_s"),
    ],
)
def test_other_keys(key, message):
    assert f"Layer.{key}: unknown key; {message}" in given(Layer, SAND, None, **{key: 0.1})
