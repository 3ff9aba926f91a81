"""The time step: which rollers are bound, the velocities of all bodies, and what a step leaves in the state."""
