"""Numerical methods that know no physics: panels, blocks of frequencies, bands, vector code."""
