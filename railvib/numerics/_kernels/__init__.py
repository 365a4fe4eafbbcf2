"""Compiled code of numerical methods."""
