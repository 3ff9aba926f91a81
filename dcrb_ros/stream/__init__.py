"""What flows from a simulation to its sinks: blocks of samples with the states, the ground truth and the events of their time."""
