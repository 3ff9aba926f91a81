"""The rules of the detector, one per file; `dcrb_ros.diagnosis.registry` lists them."""
