"""The catalogue of effects, one file an effect, and the model that they change."""
