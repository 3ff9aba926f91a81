"""Exchange of waveforms with other tools: export of recordings, import of waveforms measured elsewhere."""
