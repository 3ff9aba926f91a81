"""Recordings: written, read, repaired, replayed and reproduced."""
