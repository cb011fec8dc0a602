"""Harmonic balance of the reduced models coupled through contact elements. Double precision throughout."""

import jax

jax.config.update("jax_enable_x64", True)
