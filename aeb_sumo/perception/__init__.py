"""From the true world to what a vehicle knows of it; pure functions of arrays."""
