"""Running tasks: the scheduler of a run, what a worker does, and the lock of a directory."""
