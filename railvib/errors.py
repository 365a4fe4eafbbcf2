"""What railvib raises and warns about input."""


class InputError(ValueError):
    """A request that cannot be computed; one line names the quantity, the value and what is allowed."""


class PlausibilityWarning(UserWarning):
    """Input that is legal but unusual; the message gives the numbers and what follows from them."""


class AccuracyWarning(PlausibilityWarning):
    """A result that misses the accuracy asked for; the message gives both."""
