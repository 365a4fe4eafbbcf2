"""What railvib raises and warns about input."""

import re

_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
_HEAD, _TAIL = 300, 180
"""Characters that stay of a message that is too long: key and value before, what is allowed behind."""


class InputError(ValueError):
    """A request that cannot be computed; one line names the quantity, the value and what is allowed.

    Whatever a key or a value holds, the message is one line and no longer than a paragraph.
    """

    def __init__(self, message: str) -> None:
        if len(message) > _HEAD + _TAIL:
            message = f"{message[:_HEAD]} … {message[-_TAIL:]}"
        super().__init__(printable(message).replace("\n", r"\n").replace("\t", r"\t"))


class PlausibilityWarning(UserWarning):
    """Input that is legal but unusual; the message gives the numbers and what follows from them."""


class AccuracyWarning(PlausibilityWarning):
    """A result that misses the accuracy asked for; the message gives both."""


def printable(text: str) -> str:
    """Return a text with its control characters escaped: what a file holds must not steer a terminal."""
    return _CONTROL.sub(lambda match: ascii(match[0])[1:-1], text)
