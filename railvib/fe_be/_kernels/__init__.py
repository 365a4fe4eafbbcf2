"""Compiled code of the FE/BE model."""
