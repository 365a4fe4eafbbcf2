"""Peers: other ways to the same numbers, in plain NumPy."""
