"""Parameter sweeps: cases (vary), computed quantities (compute), executors (engines), storage (store)."""
