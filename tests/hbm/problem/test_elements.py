"""Forces of a group of elements, whatever the number of harmonics."""

import numpy as np
import pytest
from support.peers import friction

from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.law import ContactLaw
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, element_forces, force_only


@pytest.mark.parametrize(
    ("law", "highest"),
    [(CoulombCircle(), 27), (CoulombCircle(), 28), (JenkinsBox(2), 42)],
    ids=["circle 0-27", "circle 0-28", "box 0-42"],
)
def test_slipping_elements_have_forces_and_tangents_however_many_the_harmonics(law: ContactLaw, highest: int) -> None:
    """Two elements that slip: forces as without tangents, and tangents as the difference of forces."""
    harmonics, n_time = Harmonics(tuple(range(highest + 1))), 4 * highest
    group = ElementGroup(law, friction(2, 0.4, 3e4, 4e4, np.array([4.0, 6.0])), np.arange(6).reshape(2, 3))
    x = np.zeros((2, 3, harmonics.n_coefficients))
    x[:, :2, harmonics.slices[1].start] = 4e-4
    x[:, 0, harmonics.slices[2].start] = 1e-4
    assert len(group.may_slip_or_separate(x, harmonics, n_time)) == 2
    forces = element_forces(group, x, 100.0, harmonics, n_time)
    np.testing.assert_allclose(forces.force, force_only(group, x, 100.0, harmonics, n_time), rtol=1e-10, atol=1e-10)
    step = np.zeros_like(x)
    step[:, 1, harmonics.slices[1].start] = 1e-9
    ahead, back = (force_only(group, x + sign * step, 100.0, harmonics, n_time) for sign in (1, -1))
    slope = forces.tangent[:, :, :, 1, harmonics.slices[1].start]
    np.testing.assert_allclose((ahead - back) / 2e-9, slope, atol=1e-4 * 3e4)
