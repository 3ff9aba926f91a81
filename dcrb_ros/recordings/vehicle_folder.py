"""Names of the files in the folder of a vehicle's recording, beside the recordings of its boxes."""

VEHICLE_FILE = "vehicle.json"
"""Parameters of the vehicle, and the digests of the samples of its boxes."""
TRUTH_FILE = "ground_truth.jsonl"
"""A line for every block: speed, place, loads, levels of the sources in each box, joints, flats and slides."""
