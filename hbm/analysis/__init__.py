"""What can be said of a solved point: stability, sensitivities, numerical error."""
