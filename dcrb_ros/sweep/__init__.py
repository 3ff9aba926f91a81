"""Labelled data sets: a sweep file, its plan of runs, their simulation on Dask, and their labels."""
