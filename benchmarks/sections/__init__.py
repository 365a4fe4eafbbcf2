"""Sections of the benchmark: kernel, transfer functions, the paper's study, growth."""
