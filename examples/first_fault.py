"""A first bearing fault in five lines: python examples/first_fault.py writes first_fault.png."""

import dcrb_ros

run = dcrb_ros.simulate("outer_ring_defect", 4.0)
print(dcrb_ros.detect(run))
ax = dcrb_ros.plot_envelope_spectrum(run)
ax.figure.savefig("first_fault.png")
