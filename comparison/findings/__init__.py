"""Where the calibrated model fails, in sentences."""
