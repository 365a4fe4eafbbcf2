"""Speed on this machine, beside other ways to the same numbers and the limit of the processor."""
