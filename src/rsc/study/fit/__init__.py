"""Values of a scene fitted to a measured run."""
