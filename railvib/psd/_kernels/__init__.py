"""Compiled code of power spectral densities."""
