"""One bearing: from a configuration to the constants and the start of the time loop, and from its state to what is observed."""
