"""rsc: rotor-stator contact, simulated and predicted."""
