"""The time loop in blocks, its scenario and its commands."""
