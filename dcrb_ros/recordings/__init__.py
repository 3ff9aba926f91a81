"""Recordings: writing, reading, recovery, replay and reproduction."""
