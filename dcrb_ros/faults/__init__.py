"""The faults that a bench can carry."""
