"""Lives: bearings that run a duty until they fail, inspected at intervals; each inspection is a run of a sweep of kind ``life``."""
