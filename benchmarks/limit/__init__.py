"""The limit of one core: rates of floating-point operations, and how many a kernel needs."""
