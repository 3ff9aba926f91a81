"""The state and the work arrays of the time loop: tables of rollers and contacts, and the bodies' arrays."""
