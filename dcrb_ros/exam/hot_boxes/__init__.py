"""Hot boxes: lead time of the shipped detector before wayside detectors, over days of simulated axles without vibration."""
