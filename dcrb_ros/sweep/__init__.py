"""From one bearing to a data set: a sweep file, its plan of runs, the runs on Dask, their labels."""
