"""Model against measurement: prediction at the measured points, fit within bounds, where the model fails."""
