"""The exam of detectors that compare the axle boxes of a vehicle."""
