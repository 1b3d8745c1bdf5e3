"""Machines from other programs: their bodies, and the reduction of these to a few coordinates."""
