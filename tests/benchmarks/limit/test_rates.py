"""The loops whose rates are the limit compute what their operations say."""

import pytest

from benchmarks.limit.rates import loop


@pytest.mark.parametrize("length", [2, 4, 8])
def test_loops(length):
    chains = 8
    numbers = length * chains
    start = length * sum(1.0 + 0.01 * i for i in range(chains))
    # x → 3/4 x + 1/2 tends to 2, the square root to 1, and 1.7/x returns after two passes.
    assert loop("fma", length, chains)(1) == pytest.approx(0.75 * start + 0.5 * numbers)
    assert loop("fma", length, chains)(200) == pytest.approx(2.0 * numbers)
    assert loop("root", length, chains)(200) == pytest.approx(1.0 * numbers)
    assert loop("divide", length, chains)(200) == pytest.approx(start)
