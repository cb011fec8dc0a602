"""Resonances followed in the force, and their equivalent damping."""
