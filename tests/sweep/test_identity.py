import math
import string

import pytest
from hypothesis import given
from hypothesis import strategies as st

import railvib
from railvib import library
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.track import Track
from railvib.parameters.wheel_roughness import WheelRoughness
from sweep import identity

scalars = st.none() | st.booleans() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=8)
data = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.text(string.ascii_lowercase, max_size=5), inner, max_size=4)
    ),
    max_leaves=20,
)
layers = st.builds(
    Layer,
    shear_speed_m_s=st.floats(50.0, 500.0),
    dilatational_speed_m_s=st.floats(600.0, 2000.0),
    density_kg_m3=st.floats(1500.0, 2500.0),
    loss_factor=st.floats(0.0, 0.5),
)


@given(data)
def test_the_canonical_form_is_a_fixed_point(value):
    once = identity.canonical(value)
    assert identity.canonical(once) == once
    assert identity.text(once) == identity.text(value)


@given(st.dictionaries(st.text(max_size=5), scalars, min_size=2, max_size=6))
def test_key_order_does_not_matter(table):
    assert identity.digest(dict(reversed(table.items()))) == identity.digest(table)


@given(st.integers(-(2**53), 2**53))
def test_whole_numbers_are_the_same_typed_either_way(number):
    assert identity.text(number) == identity.text(float(number))


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_the_next_number_is_another_one(number):
    beside = math.nextafter(number, math.inf if number < 0 else -math.inf)
    assert (identity.text(beside) == identity.text(number)) == (beside == number)


@given(layers, st.data())
def test_each_physical_parameter_enters(layer, draw):
    name = draw.draw(st.sampled_from(["shear_speed", "dilatational_speed", "density", "loss_factor"]))
    changed = layer.model_copy(update={name: math.nextafter(getattr(layer, name), math.inf)})
    assert identity.digest(Ground(layers=(changed,))) != identity.digest(Ground(layers=(layer,)))


def test_both_zeros_are_one():
    assert identity.digest({"x": -0.0}) == identity.digest({"x": 0.0})


def test_the_order_of_layers_enters():
    soft, stiff = (
        Layer(shear_speed=speed, dilatational_speed=900.0, density=1800.0, loss_factor=0.1, thickness=1.0)
        for speed in (100.0, 300.0)
    )
    down, up = (Ground(layers=order, base="rigid") for order in ((soft, stiff), (stiff, soft)))
    assert identity.digest(down) != identity.digest(up)


@pytest.mark.parametrize("value", [math.nan, math.inf, 2**60])
def test_numbers_without_identity_are_refused(value):
    with pytest.raises(ValueError, match=r"cannot be part|too large"):
        identity.digest({"speed": value})


def test_paths_are_refused(tmp_path):
    with pytest.raises(TypeError, match="no canonical form"):
        identity.digest(tmp_path)


def test_the_model_version_enters_units_alone(monkeypatch):
    things = {
        "ground": Ground(
            layers=(Layer(shear_speed=100, dilatational_speed=200, density=1800, loss_factor=0.1),)
        )
    }
    unit, case = identity.unit_id("transfer", things), identity.case_id(things, 40.0)
    monkeypatch.setattr(railvib, "MODEL_VERSION", "another")
    assert identity.unit_id("transfer", things) != unit
    assert identity.case_id(things, 40.0) == case


def test_a_table_inside_enters_whole():
    one, other = ({"ground": {"layers": [{"density": density}]}} for density in (1800, 1801))
    assert identity.digest(one) != identity.digest(other)
    assert identity.digest(identity.canonical(one)) == identity.digest(one)


def test_what_a_vehicle_or_track_does_not_have_is_no_part_of_it():
    """Rough wheels and the coupling came later: without them an identity is made of what it was made of."""
    regina, paper = library.load("vehicle", "regina"), library.load("track", "ballasted-paper")
    assert "wheel_roughness" not in identity.canonical(regina)
    assert "coupling" not in identity.canonical(paper)
    rough = WheelRoughness(form="orders", order_level=(20.0,))
    other = regina.model_copy(update={"wheel_roughness": rough})
    assert identity.digest({"vehicle": other}) != identity.digest({"vehicle": regina})
    following = library.load("track", "ballasted-mean")
    assert identity.digest({"track": following}) != identity.digest({"track": paper})
    assert Track(**{**paper.model_dump(), "coupling": "mean"}) == following
