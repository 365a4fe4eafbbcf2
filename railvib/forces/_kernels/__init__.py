"""Compiled code of receptances and forces."""
