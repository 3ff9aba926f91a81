"""A recording in Rerun: the waveform, its envelope spectrum and the moving bearing on one timeline."""
