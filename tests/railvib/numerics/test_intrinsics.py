"""The code written in LLVM IR against NumPy."""

import numba
import numpy as np
import pytest

from railvib.numerics.intrinsics import bilinear_sum, bits, double, row_subtraction, square_moments

NUMBERS = np.array([0.0, -0.0, 1.0, -1.5, np.pi, 5e-324, -1.7e308, np.inf, -np.inf, np.nan])


def test_bits_and_double_reinterpret_a_number():
    @numba.njit
    def reinterpret(number, pattern, back):
        for i in range(number.size):
            pattern[i] = bits(number[i])
            back[i] = double(pattern[i])

    pattern, back = np.empty(NUMBERS.size, np.int64), np.empty(NUMBERS.size)
    reinterpret(NUMBERS, pattern, back)
    np.testing.assert_array_equal(pattern, NUMBERS.view(np.int64))
    np.testing.assert_array_equal(back.view(np.int64), NUMBERS.view(np.int64))


@pytest.mark.parametrize("lanes", [4, 32])
def test_row_subtraction(lanes):
    subtract_row = row_subtraction(lanes)

    @numba.njit
    def subtract(real, imag, target, source, factor):
        subtract_row(real, imag, target, source, factor)

    rng = np.random.default_rng(1)
    real, imag = rng.normal(size=(2, 3, 5, lanes))
    factor = rng.normal(size=(2, lanes))
    before = real + 1j * imag
    subtract(real, imag, 1 * 5 + 4, 2 * 5 + 3, factor)
    expected = before.copy()
    expected[1, 4] -= (factor[0] + 1j * factor[1]) * before[2, 3]
    np.testing.assert_allclose(real + 1j * imag, expected, rtol=0, atol=1e-15)
    untouched = np.ones((3, 5), bool)
    untouched[1, 4] = False
    np.testing.assert_array_equal((real + 1j * imag)[untouched], before[untouched])


@pytest.mark.parametrize(("rows", "columns"), [(10, 12), (3, 4), (1, 8)])
def test_bilinear_sum(rows, columns):
    lanes, row_weight, column_weight = 16, 2, 2 + rows
    sum_bilinear = bilinear_sum(rows, columns, lanes, row_weight, column_weight)

    @numba.njit
    def call(value, start, width, weight, lane):
        return sum_bilinear(value, start, width, weight, lane)

    rng = np.random.default_rng(2)
    start, width = 6, 2 * columns + 10
    value = rng.normal(size=start + rows * width)
    weight = rng.normal(size=(column_weight + columns, lanes))
    table = value[start:].reshape(rows, width)[:, : 2 * columns].view(complex)
    for lane in (0, 5, lanes - 1):
        expected = weight[row_weight:column_weight, lane] @ table @ weight[column_weight:, lane]
        np.testing.assert_allclose(call(value, start, width, weight, lane), expected, rtol=1e-13)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("terms", [12, 3])
def test_square_moments(terms, sign):
    node, weight = np.polynomial.legendre.leggauss(8)
    add_square_moments = square_moments(terms, node.tolist(), weight.tolist())

    @numba.njit
    def add(series, start, plane, place, sums):
        add_square_moments(series, start, plane, place, sums)

    rng = np.random.default_rng(3)
    start, plane = 5, terms + 4
    series = rng.normal(size=start + 4 * plane)
    x0, x1, y0, y1, half = 0.1, -0.4, 0.3, 0.5, 0.7
    before = rng.normal(size=(terms, node.size))
    sums = before.copy()
    add(series, start, plane, (x0, x1, y0, y1, half, sign), sums)
    p, q, r, s = (
        np.polynomial.polynomial.polyval(x0 + x1 * node, series[start + k * plane :][:terms])
        for k in range(4)
    )
    square = (p - sign * s) ** 2 + (q + sign * r) ** 2
    moments = half * weight * square * (y0 + y1 * node) ** np.arange(terms)[:, None]
    np.testing.assert_allclose(sums, before + moments, rtol=0, atol=1e-13 * np.abs(moments).max())
