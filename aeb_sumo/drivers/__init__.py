"""Human error: what drivers do that SUMO's do not. Seeded, and blind to what the AEB does."""
