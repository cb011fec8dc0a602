"""Derivatives of the friction laws by their parameters, from the tangent: against differentiation in JAX."""

from dataclasses import replace

import numpy as np
import pytest

from updamp.hbm.analysis import law_derivatives as by_parameters
from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.law import LawAt
from updamp.hbm.contact.modified.film import ViscousFilm
from updamp.hbm.contact.modified.microslip import SubPatchMicroslip
from updamp.hbm.contact.modified.modified_law import with_entries
from updamp.hbm.contact.modified.static_share import StaticShare
from updamp.hbm.contact.modified.velocity_friction import VelocityFriction
from updamp.hbm.contact.parameter_moves import derivatives_of, friction_derivatives
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup, departures, force_only

ENTRIES = FrictionParameters._fields
HARMONICS, N_TIME, ELEMENTS = Harmonics((0, 1, 2, 3)), 64, 40


def group_of(law, entries=None, **changed):
    """All different; a third is open at rest. entries: those of a modified law"""
    rng = np.random.default_rng(11)
    gap = np.where(np.arange(ELEMENTS) % 3 == 0, 1.0, 0.1) * rng.random(ELEMENTS)
    values = {
        "mu": 0.1 + rng.random(ELEMENTS), "kt": 0.5 + rng.random(ELEMENTS), "kn": 0.5 + rng.random(ELEMENTS),
        "n0": 0.2 + 0.3 * rng.random(ELEMENTS), "t0": 0.05 * rng.normal(size=(ELEMENTS, 2)), "gap": gap,
    }  # fmt: skip
    rows = np.arange(3 * ELEMENTS).reshape(-1, 3)
    return ElementGroup(law, with_entries(FrictionParameters(**(values | changed)), **(entries or {})), rows)


def motions():
    """From motions that stick to gross slip and separation."""
    rng = np.random.default_rng(12)
    motion = rng.normal(size=(ELEMENTS, 3, 7)) * np.array([0.4, 2, 2, 0.3, 0.3, 0.2, 0.2])
    return motion * np.geomspace(0.005, 2.0, ELEMENTS)[:, None, None]


def both(group, monkeypatch, entries=ENTRIES):
    """From the tangent, and with a law that does not tell."""
    x = motions()
    tangent = departures(group, x, 1.3, HARMONICS, N_TIME).tangent
    arguments = group, entries, x, tangent, 1.3, HARMONICS, N_TIME
    found = by_parameters.law_derivatives(*arguments)
    monkeypatch.setattr(by_parameters, "_is_law_of_moves", lambda _: False)
    return found, by_parameters.law_derivatives(*arguments)


@pytest.mark.parametrize(
    "law", [JenkinsBox(2), SampledJenkinsBox(2), CoulombCircle(3)], ids=lambda law: type(law).__name__
)
def test_from_the_tangent_as_by_differentiation(law, monkeypatch):
    found, expected = both(group_of(law), monkeypatch)
    for entry in ENTRIES:
        scale = np.abs(expected[entry]).max()
        assert scale > 0
        np.testing.assert_allclose(found[entry], expected[entry], rtol=0, atol=1e-12 * scale, err_msg=entry)


@pytest.mark.parametrize(
    "law",
    [
        ViscousFilm(JenkinsBox(2)), StaticShare(JenkinsBox(2)), VelocityFriction(JenkinsBox(2)),
        SubPatchMicroslip(JenkinsBox(2)), StaticShare(ViscousFilm(VelocityFriction(JenkinsBox(2)))),
        SubPatchMicroslip(VelocityFriction(JenkinsBox(2))),
    ],
    ids=["film", "share", "velocity", "microslip", "three", "microslip of velocity"],
)  # fmt: skip
def test_of_modified_laws_from_the_law_inside_against_differences(law):
    rng, x = np.random.default_rng(13), motions()
    names = tuple(name for name in law.parameters._fields if name not in ENTRIES)
    group = group_of(law, {name: 0.1 + 0.5 * rng.random(ELEMENTS) for name in names})
    tangent = departures(group, x, 1.3, HARMONICS, N_TIME).tangent
    entries = tuple(entry for entry in (*ENTRIES, *names) if entry != "t0")
    found = by_parameters.law_derivatives(group, entries, x, tangent, 1.3, HARMONICS, N_TIME)
    assert derivatives_of(law, entries, LawAt(x, tangent, group.values, 1.3, HARMONICS, N_TIME)) is not None

    def force(entry, step):
        value = getattr(group.values, entry)
        parameters = group.parameters._replace(**{entry: value + step})
        return force_only(replace(group, parameters=parameters), x, 1.3, HARMONICS, N_TIME)

    for entry in entries:
        expected = (force(entry, 1e-6) - force(entry, -1e-6)) / 2e-6
        scale = np.abs(expected).max()
        assert scale > 0
        np.testing.assert_allclose(found[entry], expected, rtol=0, atol=1e-6 * scale, err_msg=entry)


def test_of_a_film_that_is_not_there_and_of_a_mean_that_is_not_seen():
    """The former is told from the law inside, the latter by differentiation alone."""
    x, group = motions(), group_of(ViscousFilm(JenkinsBox(2)), {"viscosity": np.zeros(ELEMENTS)})
    tangent = departures(group, x, 1.3, HARMONICS, N_TIME).tangent
    found = by_parameters.law_derivatives(group, ("viscosity",), x, tangent, 1.3, HARMONICS, N_TIME)["viscosity"]
    more = replace(group, parameters=with_entries(group.parameters, viscosity=np.ones(ELEMENTS)))
    change = departures(more, x, 1.3, HARMONICS, N_TIME).force - departures(group, x, 1.3, HARMONICS, N_TIME).force
    np.testing.assert_allclose(found, change, rtol=0, atol=1e-12 * np.abs(change).max())
    unseen = with_entries(group_of(JenkinsBox(2)).parameters, static_share=np.zeros(ELEMENTS))
    at = LawAt(x, tangent, unseen, 1.3, HARMONICS, N_TIME)
    assert StaticShare(JenkinsBox(2)).parameter_derivatives(("mu",), at) is None


def test_all_copies_of_an_element_count(monkeypatch):
    copies = 1.0 + np.arange(ELEMENTS) % 2
    group = group_of(JenkinsBox(2))
    one, _ = both(group, monkeypatch)
    monkeypatch.undo()
    for several in both(replace(group, copies=copies), monkeypatch):
        for entry in ENTRIES:
            expected = one[entry] * copies.reshape(-1, *[1] * (one[entry].ndim - 1))
            np.testing.assert_allclose(several[entry], expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_without_friction_the_tangent_does_not_tell(monkeypatch):
    group = group_of(JenkinsBox(2), mu=np.zeros(ELEMENTS))
    x = motions()
    tangent = departures(group, x, 1.0, HARMONICS, N_TIME).tangent
    assert friction_derivatives(("mu",), LawAt(x, tangent, group.values, 1.0, HARMONICS, N_TIME)) is None
    found, expected = both(group, monkeypatch)
    np.testing.assert_array_equal(found["mu"], expected["mu"])
    assert np.abs(found["mu"]).max() > 0
