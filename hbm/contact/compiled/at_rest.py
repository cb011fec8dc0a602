"""What hardly departs from its spring over a period, and is taken to follow it when a perturbation is answered.

Among them are sliders that have shaken down: pushed, in the first periods, to where the motion just touches the slip
limit and no longer moves them. Their tangent there is a matter of round-off; a perturbation that decays leaves them at
rest somewhere beside, which is stuck.
"""

from typing import Any

from updamp.hbm.contact.compiled.keeping import inner

# Departure from the reference springs, relative to the force, below which there is none.
ELASTIC = 1e-8


@inner
def rests(u: Any, source: Any, position: Any) -> bool:
    """Whether a slider stays where it is. u: (n_time + 1,) motion of its spring's end [m]; source: (n_time,) or one
    more, number of the position [m] that it has at each sample"""
    low = high = position[source[0]]
    lowest = highest = u[0]
    largest = 0.0
    for t in range(len(u) - 1):
        stands = position[source[t]]
        low, high = min(low, stands), max(high, stands)
        lowest, highest = min(lowest, u[t]), max(highest, u[t])
        largest = max(largest, abs(u[t] - stands))
    return high - low <= ELASTIC * (highest - lowest + largest)


@inner
def stays_closed(pressing: Any) -> bool:
    """Whether a contact hardly opens; pressing: (n_time + 1,) compression [m]"""
    low, high = pressing.min(), pressing.max()
    return -low <= ELASTIC * (high - low + max(abs(low), abs(high)))
