"""The input model: what a rig file states, checked, in SI; effects and calibration as plain data."""
