"""One bearing: constants and initial state of the kernels from a configuration, and published states from the kernels' state."""
