"""The comparing detector of a vehicle: which axle box, and whether bearing, wheel, track, gear or sensor."""
