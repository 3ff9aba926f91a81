"""Simulation in blocks: time loop, events, scenarios, batches."""
