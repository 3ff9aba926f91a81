"""The measurement chain: from the acceleration of the outer ring to the samples of an accelerometer."""
