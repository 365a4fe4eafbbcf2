"""The numbers that standards ask for: weightings, running levels, values per day, force densities.

From time histories and spectra as arrays; nothing here knows tracks or grounds.
"""
