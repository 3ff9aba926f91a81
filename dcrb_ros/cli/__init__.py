"""The command line `dcrb`."""
