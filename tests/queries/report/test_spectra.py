"""Spectra of the page are those of the database, wherever their lines lie in it."""

import duckdb
import numpy as np
import pytest

from queries.report import spectra as narrow_band

WANTED = np.array([40, 2, 0, 5, 41])


@pytest.fixture(params=[False, True], ids=["in order", "in disorder"])
def spectra(request):
    """Return a database of spectra of different lengths, and their frequencies and densities by number."""
    random = np.random.default_rng(5)
    made = {}
    for series in range(50):
        frequency = np.concatenate([[0.0], np.sort(random.uniform(1.0, 100.0, 5 + series % 3))])
        density = random.uniform(1e-20, 1e-18, frequency.size)
        density[2] = np.nan
        made[series] = frequency, density
    rows = [
        (series, f, None if np.isnan(s) else s)
        for series, (frequency, density) in made.items()
        for f, s in zip(frequency.tolist(), density.tolist(), strict=True)
    ]
    if request.param:
        rows = [rows[i] for i in random.permutation(len(rows))]
    with duckdb.connect() as connection:
        connection.execute("CREATE TABLE psd_lines (series_id INTEGER, frequency_hz DOUBLE, value DOUBLE)")
        columns = [list(column) for column in zip(*rows, strict=True)]
        connection.execute("INSERT INTO psd_lines SELECT unnest($1), unnest($2), unnest($3)", columns)
        yield connection, made


@pytest.mark.parametrize("at_once", [2, 64])
def test_each_spectrum_has_its_own_lines_above_zero(spectra, monkeypatch, at_once):
    monkeypatch.setattr(narrow_band, "_SPECTRA_AT_ONCE", at_once)
    connection, made = spectra
    found = {place: lines for place, *lines in narrow_band._lines(connection, WANTED)}
    assert sorted(found) == list(range(WANTED.size))
    for place, series in enumerate(WANTED.tolist()):
        for got, expected in zip(found[place], made[series], strict=True):
            np.testing.assert_array_equal(got, expected[1:])


def test_spectra_on_different_lines_are_given_on_all_of_them(spectra):
    connection, made = spectra
    frequency, density = narrow_band._all(narrow_band._lines(connection, WANTED), WANTED.size)
    np.testing.assert_array_equal(
        frequency, np.unique(np.concatenate([made[series][0][1:] for series in WANTED.tolist()]))
    )
    for row, series in zip(density, WANTED.tolist(), strict=True):
        own = np.isin(frequency, made[series][0])
        np.testing.assert_array_equal(row[own], made[series][1][1:])
        assert np.isnan(row[~own]).all()


def test_bins_have_the_least_and_the_largest_line(spectra):
    connection, made = spectra
    lines = narrow_band._lines(connection, WANTED)
    midpoints, density = narrow_band._extremes(lines, WANTED.size, 10, 1.0, 100.0)
    edges = np.geomspace(1.0, 100.0, 11)
    np.testing.assert_allclose(midpoints, np.sqrt(edges[1:] * edges[:-1]))
    for row, series in zip(density.reshape(-1, 10, 2), WANTED.tolist(), strict=True):
        frequency, value = made[series]
        for i, ends in enumerate(row):
            inside = value[(frequency >= edges[i]) & (frequency < edges[i + 1]) & ~np.isnan(value)]
            expected = (inside.min(), inside.max()) if inside.size else (np.nan, np.nan)
            np.testing.assert_array_equal(ends, expected)
