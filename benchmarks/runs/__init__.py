"""Runs of studies in processes of their own, and what they cost."""
