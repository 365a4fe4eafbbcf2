"""Forecast of a run: rates of this machine, amounts of work, memory and disk."""
