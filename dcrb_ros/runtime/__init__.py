"""Processes, threads, signals and exit statuses."""
