"""Settings of a bench: parameters, their limits, and the files they are read from."""
