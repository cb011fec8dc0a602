"""Models with an effect, fitted to the data, and the one without that they have to beat."""
