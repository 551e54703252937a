"""What a car does with a demand: lower controller and brake."""
