"""Measured runs: signals of two probes and of the shaft, as laboratories keep them, made into what spectra and orbits take."""
