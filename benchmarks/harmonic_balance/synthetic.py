"""A structure on a number of contacts of one's choice, to see how the cost grows.

Whatever their number, the contacts are one patch of the same stiffness and preload, more finely divided.
"""

import jax.numpy as jnp
import numpy as np

from updamp.benchmarks.sensitivity_cost import with_residual
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel
from updamp.hbm.problem.system import Excitation, NonlinearSystem

MODES, SEED = 60, 3
FIRST_HZ, LAST_HZ = 230.0, 20e3
TANGENTIAL, NORMAL = 2e7, 3e7  # N/m, of the whole patch
PRELOAD, FRICTION, FORCE = 300.0, 0.5, 5.0  # N, -, N


def synthetic(contacts: int, orders: tuple[int, ...] = (0, 1, 2, 3), time_samples: int = 128) -> NonlinearSystem:
    """Two named points, `tip` and `excitation`, and residual flexibility with the spectrum measured on a rig."""
    share = np.full(contacts, 1 / contacts)
    place = np.random.default_rng(SEED).uniform(-1, 1, (contacts, 2))
    uneven = 1 + 0.8 * np.tanh(2 * place[:, 0])  # preload from a fifth to nine fifths of the mean
    parameters = FrictionParameters(
        mu=jnp.full(contacts, FRICTION),
        kt=jnp.asarray(TANGENTIAL * share),
        kn=jnp.asarray(NORMAL * share),
        n0=jnp.asarray(PRELOAD * share * uneven),
        t0=jnp.zeros((contacts, 2)),
        gap=jnp.zeros(contacts),
    )
    group = ElementGroup(JenkinsBox(2), parameters, np.arange(3 * contacts).reshape(contacts, 3))
    return with_residual(NonlinearSystem(_structure(place), (group,), Harmonics(orders), time_samples))


def _structure(place: np.ndarray) -> LinearModel:
    """Mode shapes are smooth over the patch: polynomials of second order in place, with random factors.

    place: (n_contacts, 2), each within -1 and 1
    """
    rng = np.random.default_rng(SEED + 1)
    s, t = place.T
    shapes = np.stack([np.ones_like(s), s, t, s * t, s**2, t**2], axis=1)  # (n_contacts, 6)
    factors = rng.normal(size=(6, 3, MODES)) * np.array([1, 0.5, 0.5, 0.25, 0.25, 0.25])[:, None, None]
    contacts = 0.15 * np.einsum("np,pdm->ndm", shapes, factors).reshape(3 * len(place), MODES)
    points = rng.normal(size=(2, MODES))
    points[:, 0] = 3.0  # the mode that resonates
    omega_squared = (2 * np.pi * np.geomspace(FIRST_HZ, LAST_HZ, MODES)) ** 2
    return LinearModel(
        omega_squared=omega_squared,
        phi=np.vstack([contacts, points]),
        residual=np.zeros((3 * len(place) + 2, 3 * len(place) + 2)),
        hysteretic=0.002 * np.diag(omega_squared),
        viscous=np.zeros((MODES, MODES)),
        n_relative=3 * len(place),
        points=("excitation", "tip"),
    )


def excitation(system: NonlinearSystem, force: float = FORCE) -> Excitation:
    return Excitation(system.free.row("excitation"), force)


def window(system: NonlinearSystem) -> tuple[float, float]:
    """About the first mode, from a little below it free to a little above it stuck [Hz]."""
    return 0.985 * float(system.free.frequencies[0]), 1.015 * float(system.stuck.frequencies[0])
