"""What a sensor makes of the outer ring's motion."""
