"""Power spectral densities by moving roughness and by the full model."""
