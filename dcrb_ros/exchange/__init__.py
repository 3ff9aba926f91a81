"""Waveforms in the files of other tools: out of a recording, and into one."""
