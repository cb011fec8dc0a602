"""What the static contact stage hands on: the rest state of every contact element."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StaticContact:
    """Rest state under the pull, one entry a contact element.

    normal_force: (n,) N0 >= 0, pressing [N]
    tangential_force: (n, 2) force of the platform on the damper's motion along (t1, t2) at rest, T0 [N]
    gap: (n,) opening at rest where there is no contact, else 0 [m]
    applied: pull on the damper [N]
    normal_total: sum of normal_force over both faces [N]
    equilibrium_error: |vertical resultant of the contacts - applied| / applied
    """

    model: str
    normal_force: Floats
    tangential_force: Floats
    gap: Floats
    applied: float
    normal_total: float
    equilibrium_error: float
