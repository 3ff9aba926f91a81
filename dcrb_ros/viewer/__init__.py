"""The view of a recording or of a running bench in Rerun: waveform, squared envelope spectrum and moving bearing on one timeline."""
