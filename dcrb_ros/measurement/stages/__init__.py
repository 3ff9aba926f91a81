"""The stages of the measurement chain, one per file; `dcrb_ros.measurement.registry` puts them in order."""
