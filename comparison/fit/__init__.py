"""Fit of what is known only roughly, with the scatter of repeats and the numerical error."""
