"""Figures of the results, drawn with Matplotlib."""

from queries.figures.processes import WORKERS, FigureProcesses

__all__ = ["WORKERS", "FigureProcesses"]
