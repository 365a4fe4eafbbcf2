"""The physical inputs of a case: frozen, and checked when they are made."""
