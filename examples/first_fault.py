"""A first bearing fault in five lines: python examples/first_fault.py writes spectrum.png."""

import dcrb_ros

configuration = dcrb_ros.load_configuration("outer_ring_defect", ["operating.speed=100.0"])
run = dcrb_ros.simulate(configuration, duration=4.0)
print(dcrb_ros.detect(run))
dcrb_ros.plot_envelope_spectrum(run).figure.savefig("spectrum.png")
