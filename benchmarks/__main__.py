"""Measures railvib on this machine."""

from benchmarks.cli import benchmark

benchmark()
