"""The vocabulary below the physics: fields of parameters, verdicts, refusals, checked numbers, arrays and simulated time."""
