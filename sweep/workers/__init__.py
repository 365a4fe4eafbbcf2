"""Processes that compute: on this machine, over SSH, and from batch systems."""
