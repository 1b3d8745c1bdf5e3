"""Measured runs: reads signals of two probes and the shaft for spectra and orbits."""
