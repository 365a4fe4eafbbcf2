"""Compiled code of the transfer functions."""
