"""Finite elements: assembly, modes, reduction with residual flexibility, check on the full model."""
