"""The values of an axis that is given as a range."""

import math

import pytest

from railvib.errors import InputError
from sweep.study.ranges import axis


@pytest.mark.parametrize(
    ("value", "values"),
    [
        ({"start": 50, "stop": 60, "step": 5}, [50.0, 55.0, 60.0]),
        ({"start": 0.1, "stop": 0.5, "step": 0.1}, [0.1, 0.2, 0.3, 0.4, 0.5]),
        ({"start": 10, "stop": 25, "step": 10}, [10.0, 20.0]),
        ({"start": 10, "stop": 1000, "number": 3, "scale": "log"}, [10.0, 100.0, 1000.0]),
        ({"start": 10, "stop": 20, "number": 3}, [10.0, 15.0, 20.0]),
        ([150], [150]),
    ],
)
def test_values(value, values):
    assert axis(value) == values


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (
            {"start": 1, "stop": 2, "steps": 1},
            ": must be a list, {start, stop, step} or {start, stop, number",
        ),
        ({"start": 9, "stop": 2, "step": 1}, ".start = 9: must be below stop = 2"),
        ({"start": 1, "stop": 2, "step": 0}, ".step = 0: must be above 0"),
        ({"start": 1, "stop": 2, "step": 1e-9}, ".step = 1e-09: makes 1e+09 values; must be at most 100000"),
        ({"start": 1, "stop": 2, "step": 1e-300}, ".step = 1e-300: makes 1e+300 values"),
        ({"start": 1, "stop": 2, "step": 5e-324}, ".step = 4.94066e-324: makes inf values"),
        ({"start": 1, "stop": 2, "step": True}, ".step = True: must be a finite number"),
        ({"start": "1", "stop": 2, "step": 1}, ".start = '1': must be a finite number"),
        ({"start": math.nan, "stop": 2, "step": 1}, ".start = nan: must be a finite number"),
        ({"start": 1, "stop": 2, "number": 1.5}, ".number = 1.5: must be an integer of 2 or more"),
        ({"start": 1, "stop": 2, "number": 1e18}, ".number = 1e+18: makes 1e+18 values"),
        ({"start": 0, "stop": 2, "number": 3, "scale": "log"}, ".start = 0: must be above 0"),
        ({"start": 1, "stop": 2, "number": 3, "scale": "ln"}, '.scale = \'ln\': must be "log" or "linear"'),
        ({"start": 1, "stop": 2, "number": 3, "scale": ["log"]}, ".scale = ['log']: must be"),
    ],
)
def test_refused_ranges(value, message):
    with pytest.raises(InputError) as refusal:
        axis(value)
    assert str(refusal.value).startswith(message)
