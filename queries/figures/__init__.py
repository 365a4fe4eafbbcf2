"""Figures of the results, drawn with Matplotlib."""
