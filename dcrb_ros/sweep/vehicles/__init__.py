"""Sweeps over vehicles: every box of every vehicle is a run, and a vehicle is in one split with all its boxes."""
