"""The exam of a fault detector: scenarios with known truth, what the detector said of them, marks and a report."""
