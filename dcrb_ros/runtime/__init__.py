"""Processes, threads, signals, exit status and simulated time."""
