"""Features of vibration signals for classifiers: one module per family, all listed in `registry`."""
