"""The exam of a fault detector: scenarios with known ground truth, the evaluation of the diagnoses, and a report."""
