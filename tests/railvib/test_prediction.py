"""One case from Python, against the parts it is made of; what it refuses, and what it warns of."""

import re
import warnings

import numpy as np
import pytest

from railvib import library
from railvib.errors import InputError, PlausibilityWarning
from railvib.numerics import third_octaves
from railvib.parameters.ground import Ground, Layer
from railvib.parameters.track import TrackLayer
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import KMH
from railvib.parameters.vehicle import Train
from railvib.plausibility import check_speed
from railvib.prediction import predict, predict_passage, rail_receptance
from railvib.psd.lines import lines

SPEED = 30.0
ROUGH = Unevenness(form="fra-hamid-yang", line_class=3)
SOFT = Ground(layers=[Layer(shear_speed=150.0, dilatational_speed=400.0, density=1800.0, loss_factor=0.1)])
LIMITS = {"minimum_frequency": 4.0, "maximum_frequency": 16.0}


@pytest.fixture(scope="module")
def single(vehicle):
    return Train(vehicles=[vehicle])


@pytest.fixture(scope="module")
def case(track, single):
    return predict(SOFT, track, single, ROUGH, SPEED, [0.0, 8.0], **LIMITS)


@pytest.fixture(scope="module")
def passage(track, single):
    return predict_passage(SOFT, track, single, ROUGH, SPEED, [8.0], passages=256, **LIMITS)


def level(data, receiver=None):
    chosen = data if receiver is None else data.sel(receiver=receiver)
    return 10.0 * np.log10(chosen)


class TestDataset:
    def test_axes(self, case):
        assert list(case.approach.values) == ["moving-roughness", "moving-roughness-uncorrelated", "full"]
        assert list(case.receiver.values) == ["rail", "ground 0 m", "ground 8 m"]
        np.testing.assert_array_equal(case.offset, [np.nan, 0.0, 8.0])
        np.testing.assert_allclose(case.band, third_octaves.midbands(4.0, 16.0))
        assert set(case.axle.values) == {1, 2, 3, 4}
        assert all(np.isfinite(case[name]).all() for name in case.data_vars)

    def test_total_is_the_sum_of_contributions(self, case):
        for name in ("velocity_psd", "velocity_mean_square"):
            dynamic, still, total = (
                case[name].sel(contribution=each) for each in ("dynamic", "quasi-static", "total")
            )
            np.testing.assert_allclose(total, dynamic + still, rtol=1e-12)
            assert (dynamic > 0.0).all()
            # Constant axle loads give every approach the same.
            np.testing.assert_allclose(still, still.isel(approach=[0] * 3), rtol=1e-12)

    def test_bands_are_integrals_of_lines(self, case, single):
        psd = case.velocity_psd.sel(approach="full", contribution="dynamic")
        mean_square = lines(tuple(case.band.values), single, SPEED).mean_squares(psd.values)
        np.testing.assert_allclose(
            case.velocity_mean_square.sel(approach="full", contribution="dynamic"), mean_square, rtol=1e-12
        )

    def test_forces_are_those_of_the_coupled_system(self, case, track, single):
        """Eq. 12 assembled from `rail_receptance` and the vehicle, one line of the moving roughness."""
        from railvib.parameters.vehicle import train_receptance

        line = int(np.argmin(np.abs(case.frequency.values - 9.0)))
        f = float(case.frequency[line])
        alpha = single.axle_positions
        for approach, speed in (("moving-roughness", 0.0), ("full", SPEED)):
            matrix = rail_receptance(track, SOFT, f, alpha[:, None] - alpha, speed)
            matrix = (
                matrix + train_receptance(single, 2.0 * np.pi * f) + np.diag(1.0 / single.contact_stiffness)
            )
            force = np.linalg.solve(matrix, -np.exp(2j * np.pi * f / SPEED * alpha))
            beta = 2.0 * np.pi * f / SPEED
            expected = np.abs(force) ** 2 * ROUGH.psd(beta) * 2.0 * np.pi / SPEED
            by_number = (
                case.force_psd.sel(approach=approach).isel(frequency=line).sortby("axle", ascending=False)
            )
            np.testing.assert_allclose(
                by_number, expected, rtol=1e-3
            )  # twice the tables' 1e-4, and their interpolation


class TestConvergence:
    def test_bands_move_by_less_than_a_tenth_of_a_decibel(self, case, track, single):
        """All steps halved, all ranges doubled."""
        finer = predict(SOFT, track, single, ROUGH, SPEED, [0.0, 8.0], refinement=2, **LIMITS)
        assert finer.frequency.size > 1.9 * case.frequency.size
        for name in ("velocity_mean_square", "force_mean_square"):
            assert np.abs(level(finer[name]) - level(case[name])).max() < 0.1, name

    def test_tolerance(self, case, track, single):
        rough = predict(SOFT, track, single, ROUGH, SPEED, [0.0, 8.0], tolerance=1e-3, **LIMITS)
        assert np.abs(level(rough.velocity_mean_square) - level(case.velocity_mean_square)).max() < 0.05


class TestVariants:
    def test_receivers_are_independent(self, case, track, single):
        alone = predict(SOFT, track, single, ROUGH, SPEED, [8.0], rail=False, approaches=["full"], **LIMITS)
        assert list(alone.receiver.values) == ["ground 8 m"]
        together = case.velocity_psd.sel(approach=["full"], receiver=["ground 8 m"])
        np.testing.assert_array_equal(alone.velocity_psd, together)

    def test_rail_only(self, case, track, single):
        alone = predict(SOFT, track, single, ROUGH, SPEED, approaches=["moving-roughness"], **LIMITS)
        np.testing.assert_array_equal(
            alone.velocity_psd, case.velocity_psd.sel(approach=["moving-roughness"], receiver=["rail"])
        )

    def test_unlike_vehicles(self, track, vehicle):
        other = vehicle.model_copy(
            update={"car_mass": 60000.0, "length": 24.0, "bogie_spacing": 17.0, "axle_load": 189150.0}
        )
        train = Train(vehicles=[vehicle, other])
        mixed = predict(SOFT, track, train, ROUGH, SPEED, [8.0], **LIMITS)
        assert mixed.axle.size == 8
        assert np.isfinite(mixed.velocity_psd).all()
        turned = predict(SOFT, track, Train(vehicles=[other, vehicle]), ROUGH, SPEED, [8.0], **LIMITS)
        # Uncorrelated axles on a symmetric track: the order of the vehicles does not count for the standing
        # train.
        first, second = (
            each.velocity_psd.sel(approach="moving-roughness-uncorrelated", contribution="dynamic")
            for each in (mixed, turned)
        )
        np.testing.assert_allclose(first, second, rtol=1e-9)

    def test_slab_track(self, single):
        slab = library.load("track", "slab-example")
        made = predict(
            SOFT, slab, single, ROUGH, SPEED, [0.0, 8.0], approaches=["moving-roughness", "full"], **LIMITS
        )
        assert np.isfinite(made.velocity_psd).all()
        stiff = slab.model_copy(update={"mat": TrackLayer(stiffness=1e15)})
        same = predict(
            SOFT, stiff, single, ROUGH, SPEED, [0.0, 8.0], approaches=["moving-roughness", "full"], **LIMITS
        )
        np.testing.assert_allclose(same.velocity_mean_square, made.velocity_mean_square, rtol=1e-4)
        soft = slab.model_copy(update={"mat": TrackLayer(stiffness=2e7, loss_factor=0.1)})
        other = predict(SOFT, soft, single, ROUGH, SPEED, [8.0], approaches=["moving-roughness"], **LIMITS)
        assert np.isfinite(other.velocity_psd).all()

    def test_stiff_embankment_without_mass_changes_nothing(self, case, track, single):
        stiff = track.model_copy(update={"layers": (*track.layers, TrackLayer(stiffness=1e15))})
        made = predict(SOFT, stiff, single, ROUGH, SPEED, [0.0, 8.0], **LIMITS)
        np.testing.assert_allclose(made.velocity_mean_square, case.velocity_mean_square, rtol=1e-4)
        heavy = track.model_copy(
            update={"layers": (*track.layers, TrackLayer(stiffness=1e9, mass=8000.0, loss_factor=0.05))}
        )
        made = predict(SOFT, heavy, single, ROUGH, SPEED, [8.0], approaches=["moving-roughness"], **LIMITS)
        assert np.isfinite(made.velocity_psd).all()

    def test_rigid_base(self, track, single):
        (layer,) = SOFT.layers
        deep = Ground(layers=[layer.model_copy(update={"thickness": 150.0})], base="rigid")
        shallow = Ground(layers=[layer.model_copy(update={"thickness": 3.0})], base="rigid")
        arguments = (track, single, ROUGH, SPEED, [8.0])
        choice = {"approaches": ["moving-roughness"], **LIMITS}
        half_space, below, rock = (
            level(
                predict(ground, *arguments, **choice).velocity_mean_square.sel(
                    contribution="dynamic", receiver="ground 8 m"
                )
            )
            for ground in (SOFT, deep, shallow)
        )
        # 150 m of this soil swallow waves of 4 Hz and more; 3 m let none pass below their cut-off at 12 Hz.
        np.testing.assert_allclose(below, half_space, atol=0.3)
        assert (rock[0, :3] < half_space[0, :3] - 10.0).all()

    @pytest.mark.parametrize("speed", [1.5, 8.0])
    def test_slow_train(self, speed, track, single):
        """The constant loads' wavenumbers 2πf/v lie far beyond the tables, where nothing is left of the
        response.
        """
        made = predict(
            SOFT, track, single, ROUGH, speed, [8.0], approaches=["moving-roughness", "full"], **LIMITS
        )
        assert np.isfinite(made.velocity_psd).all()
        still = made.velocity_mean_square.sel(contribution="quasi-static", receiver="ground 8 m")
        assert (
            still <= 1e-12 * made.velocity_mean_square.sel(contribution="dynamic", receiver="ground 8 m")
        ).all()

    def test_twice_the_unevenness(self, case, track, single):
        rougher = ROUGH.model_copy(update={"line_class": 1})
        made = predict(SOFT, track, single, rougher, SPEED, [0.0, 8.0], **LIMITS)
        dynamic = {"contribution": "dynamic"}
        ratio = made.velocity_mean_square.sel(dynamic) / case.velocity_mean_square.sel(dynamic)
        np.testing.assert_allclose(ratio, 15.53 / 4.92, rtol=1e-9)


class TestRefusals:
    @pytest.mark.parametrize("speed", [0.0, -10.0, 1e-3, 3e8, np.nan, np.inf])
    def test_speed(self, speed, track, single):
        with pytest.raises(InputError, match=r"speed = .* m/s"):
            predict(SOFT, track, single, ROUGH, speed, [8.0])

    @pytest.mark.parametrize("offset", [-1.0, 1e5, np.nan, np.inf])
    def test_offset(self, offset, track, single):
        with pytest.raises(InputError, match=r"offset = .* m"):
            predict(SOFT, track, single, ROUGH, SPEED, [8.0, offset])

    def test_approach(self, track, single):
        with pytest.raises(InputError, match="approach = 'exact'"):
            predict(SOFT, track, single, ROUGH, SPEED, [8.0], approaches=["exact"])
        with pytest.raises(InputError):
            predict(SOFT, track, single, ROUGH, SPEED, [8.0], approaches=[])

    def test_receivers(self, track, single):
        with pytest.raises(InputError, match="no receiver"):
            predict(SOFT, track, single, ROUGH, SPEED, rail=False)

    @pytest.mark.parametrize("limits", [(0.0, 10.0), (10.0, 5.0), (np.nan, 10.0), (-1.0, 10.0)])
    def test_frequencies(self, limits, track, single):
        with pytest.raises(InputError):
            predict(
                SOFT,
                track,
                single,
                ROUGH,
                SPEED,
                [8.0],
                minimum_frequency=limits[0],
                maximum_frequency=limits[1],
            )

    @pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan, np.inf])
    def test_tolerance(self, tolerance, track, single, monkeypatch):
        def computes(*_arguments):
            raise AssertionError("a tolerance that cannot be met is computed with")

        monkeypatch.setattr("railvib.prediction.evaluate", computes)
        with pytest.raises(InputError, match="tolerance"):
            predict(SOFT, track, single, ROUGH, SPEED, [8.0], tolerance=tolerance, **LIMITS)
        with pytest.raises(InputError, match="tolerance"):
            rail_receptance(track, SOFT, 3.3, tolerance=tolerance)

    @pytest.mark.parametrize("refinement", [0, -1, 3])
    def test_refinement(self, refinement, track, single):
        with pytest.raises(InputError, match="refinement"):
            predict(SOFT, track, single, ROUGH, SPEED, [8.0], refinement=refinement, **LIMITS)

    @pytest.mark.parametrize(
        "arguments", [(-1.0, 0.0, 0.0), (np.nan, 0.0, 0.0), (5.0, 0.0, -3.0), (5.0, np.nan, 0.0)]
    )
    def test_rail_receptance(self, arguments, track):
        frequency, distance, speed = arguments
        with pytest.raises(InputError):
            rail_receptance(track, SOFT, frequency, distance, speed)


class TestPassage:
    def test_axes(self, passage, case):
        assert list(passage.approach.values) == list(case.approach.values)
        assert list(passage.receiver.values) == ["rail", "ground 8 m"]
        assert passage.velocity.dims == ("approach", "passage", "receiver", "time")
        assert passage.velocity.attrs["unit"] == "m/s"
        assert passage.unit.sel(metric="vdv") == "m/s^1.75"
        assert np.isfinite(passage.level.sel(statistic=["mean", "q0.05", "q0.5", "q0.95"])).all()

    def test_the_train_is_here_at_0_s(self, passage, single):
        """Two thirds of the energy on the rail come while the train passes, and its half before and after."""
        energy = (passage.variance + passage.quasi_static**2).sel(receiver="rail")
        here = np.abs(passage.time) < single.length / SPEED
        assert (energy.where(here, 0.0).sum("time") > 0.66 * energy.sum("time")).all()

    def test_variance_over_time_is_that_of_the_samples(self, passage):
        """Its sum over time within five standard errors, of 256 passages."""
        square = ((passage.velocity - passage.quasi_static) ** 2).sum("time")
        error = square.std("passage") / np.sqrt(passage.sizes["passage"])
        assert (np.abs(square.mean("passage") - passage.variance.sum("time")) < 5.0 * error).all()

    def test_energy_of_the_full_model_is_that_of_its_spectrum(self, passage, case, single):
        """Over all bands to 0.1 dB: the record's lines end up to a step short of the outermost edges."""
        step = float(passage.time[1] - passage.time[0])
        energy = passage.variance.sel(approach="full", receiver="ground 8 m").sum() * step
        mean_square = case.velocity_mean_square.sel(
            approach="full", receiver="ground 8 m", contribution="dynamic"
        )
        ratio = energy / (mean_square.sum() * single.length / SPEED)
        assert abs(level(float(ratio))) < 0.1

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"metrics": ("kb",)}, "metric = 'kb': must be one of kb-f-max"),
            ({"metrics": ()}, "metrics is empty"),
            ({"quantiles": (1.0,)}, "quantile = 1.0: must be above 0 and below 1"),
            ({"passages": 8}, "passages = 8: must be"),
            ({"seed": -1}, "seed = -1: must not be negative"),
        ],
    )
    def test_refusals(self, track, single, change, message):
        with pytest.raises(InputError, match=message):
            predict_passage(SOFT, track, single, ROUGH, SPEED, [8.0], **LIMITS, **change)


class TestWarnings:
    def test_usual_cases_warn_of_nothing(self, track, horstwalde):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_speed(horstwalde, track, 150.0 / KMH)
            check_speed(SOFT, track, SPEED)

    def test_faster_than_the_surface_wave(self, track, single):
        with pytest.warns(PlausibilityWarning) as record:
            made = predict(SOFT, track, single, ROUGH, 160.0, [8.0], approaches=["full"], **LIMITS)
        messages = [str(each.message) for each in record]
        # Rayleigh's equation for c_s = 150, c_p = 400 m/s gives 141.7 m/s; a loss factor of 0.1 adds 0.4 %.
        assert any(
            re.search(r"160\.0 m/s \(576 km/h\) exceeds the slowest.* 142\.\d m/s", m) for m in messages
        )
        assert any("critical speed of track and ground" in m for m in messages)
        assert np.isfinite(made.velocity_psd).all()

    def test_frequency_at_rest_is_the_static_receptance(self, track):
        low = rail_receptance(track, SOFT, [0.0, 0.02])
        assert low[0] == pytest.approx(low[1], rel=1e-6)
