"""Laws in JAX, most of which are compiled here to be run a few times."""

from collections.abc import Iterator
from functools import partial

import jax
import pytest


@pytest.fixture(scope="package", autouse=True)
def _laws_are_not_optimised() -> Iterator[None]:
    """They compile in half of the time and run three times as long. Not for all tests: curves and fits with the circle
    law, which run it thousands of times, took half as long again in all."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(jax, "jit", partial(jax.jit, compiler_options={"xla_backend_optimization_level": 0}))
        yield
