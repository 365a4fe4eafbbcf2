"""Figures of the results, drawn with Matplotlib."""

from queries.figures.catalogue import are_drawn
from queries.figures.lines import approach_line
from queries.figures.processes import WORKERS, FigureProcesses

__all__ = ["WORKERS", "FigureProcesses", "approach_line", "are_drawn"]
