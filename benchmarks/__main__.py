"""Runs the benchmark: ``python -m benchmarks``."""

from benchmarks.cli import benchmark

benchmark(prog_name="python -m benchmarks")
