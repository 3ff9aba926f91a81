"""Plots with matplotlib: waveform, squared envelope spectrum with the fault lines, load zone."""
