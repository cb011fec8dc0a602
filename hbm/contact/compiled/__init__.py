"""Contact laws written out for numba, with their tangents by hand: the same functions as those in JAX, much faster.

The laws in JAX remain the definition: effects and sensitivities differentiate them, and tests compare these with them.
"""
