"""Compiled code of random passages."""
