"""The vocabulary below the physics: fields of parameters, and verdicts."""
