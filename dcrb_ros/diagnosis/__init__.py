"""From a measured waveform to a verdict: envelope, orders of the shaft, fault lines."""
