"""Calibration of the bench to a machine from healthy recordings, and the comparison of two recordings."""
