"""What railvib raises and warns about input."""

import re

_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


class InputError(ValueError):
    """A request that cannot be computed; one line names the quantity, the value and what is allowed."""


class PlausibilityWarning(UserWarning):
    """Input that is legal but unusual; the message gives the numbers and what follows from them."""


class AccuracyWarning(PlausibilityWarning):
    """A result that misses the accuracy asked for; the message gives both."""


def printable(text: str) -> str:
    """Return a text with its control characters escaped: what a file holds must not steer a terminal."""
    return _CONTROL.sub(lambda found: ascii(found[0])[1:-1], text)
