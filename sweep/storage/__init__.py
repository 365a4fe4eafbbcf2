"""Stores of results: Zarr groups, commit records, and where they lie."""
