"""What the user says about a bench: parameters, their limits, and the files they are read from."""
