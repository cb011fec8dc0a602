"""March a slider through cycles of a periodic motion and return the last one."""

from collections.abc import Callable
from typing import Any

import jax


def last_cycle(
    step: Callable[[jax.Array, Any], tuple[jax.Array, Any]], start: jax.Array, samples: Any, cycles: int
) -> Any:
    """Scan `step(history, sample) -> (history, output)` over `cycles` periods of `samples`; outputs of the last."""
    history = start
    for _ in range(cycles - 1):
        history, _ = jax.lax.scan(lambda h, s: (step(h, s)[0], None), history, samples)
    return jax.lax.scan(step, history, samples)[1]
