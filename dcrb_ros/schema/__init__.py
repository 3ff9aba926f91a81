"""Fields of parameters: unit, range, description and remedy."""
