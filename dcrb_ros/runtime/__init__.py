"""Processes, threads, signals and exit status."""
