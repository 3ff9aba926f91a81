"""Data for the sinks: blocks of samples with their states, ground truth and events, and the diagnoses made of them."""
