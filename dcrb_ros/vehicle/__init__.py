"""A bogie with several monitored axle boxes: one track, one clock, and a path from every source to every box."""
