"""The contacts: where rollers, rings and cages touch, and their forces as straight lines over the mean speeds of a step."""
