"""Labelled data sets: a sweep file, its plan of runs, their simulation on this machine or on a Dask cluster, and their labels."""
