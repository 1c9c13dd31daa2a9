"""What lone robots and fleets share: their shell, and robots and floors as arrays."""
