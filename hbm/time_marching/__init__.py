"""Marching the reduced model in time, and whether a motion of the harmonic balance stays there."""
