"""Peaks of a model with a slipping contact against runs of it: what is amiss is read, where nothing is, nothing."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.small_model import NUISANCES, condition, parametrisation, swept_run, synthetic_plan

from updamp.comparison.findings.all_findings import all_findings
from updamp.comparison.findings.backbone import loss_by_phase, read_resonance
from updamp.comparison.findings.direction import Direction
from updamp.comparison.findings.kinds import Amplitude, Damping, Frequency, SensorGain
from updamp.comparison.findings.peak_misfit import PeakMisfit, by_repeats, peak_misfits, without_peak
from updamp.comparison.findings.peak_reading import damping_noise, swept_branch, tops_of_run
from updamp.comparison.findings.peak_sentences import peak_findings, without_peak_findings
from updamp.comparison.findings.tops import highest
from updamp.comparison.fit.compared import compare_at
from updamp.comparison.fit.fit import Fit
from updamp.comparison.fit.observations import Observations, Plan
from updamp.comparison.fit.repeat_scatter import of_repeats
from updamp.comparison.fit.scatter import Scatter
from updamp.comparison.prediction.predicted_branch import PredictedBranch
from updamp.comparison.prediction.traced_branch import trace_branch

WINDOW = (41.2, 43.2)
CONDITIONS = (
    condition(1.0, window=WINDOW),
    condition(4.0, window=WINDOW),
    condition(6.0, upwards=False, window=WINDOW),
)
NONE = np.zeros(4)
SCATTER = np.array([n.scatter for n in NUISANCES])
KNOWN = Scatter({n.name: n.scatter for n in NUISANCES}, drift=5e-5, gain=0.005)
NAMES = {"a.x": "a", "b.x": "b"}


@pytest.fixture(scope="module")
def branches() -> tuple[PredictedBranch, ...]:
    return tuple(trace_branch(parametrisation(), NONE, c) for c in CONDITIONS)


@pytest.fixture(scope="module")
def plans() -> list[Plan]:
    return [synthetic_plan(parametrisation(), NONE, CONDITIONS, SCATTER, seed)[0] for seed in range(2)]


def misfits(plan: Plan, branches: tuple[PredictedBranch, ...]) -> tuple[PeakMisfit, ...]:
    """At parameters that are known exactly."""
    compared = compare_at(parametrisation(), NONE, plan, branches, KNOWN)
    return peak_misfits(Fit(parametrisation(), compared, 1e-12 * np.eye(4), ""), plan, branches)


def changed(plan: Plan, change: Callable[[Observations], np.ndarray]) -> Plan:
    """change(run) -> (m,) what is added to its observations"""
    return replace(plan, observations=tuple(replace(o, observed=o.observed + change(o)) for o in plan.observations))


@pytest.mark.parametrize("points", [7, 11, 21])
def test_few_points_are_read_alike_wherever_they_lie_about_the_top(branches, points: int) -> None:
    """Exact runs of the very model, half a point to three in a half-width: by points about its own top it was read 6 %
    off them in height, and what the phase tells of the damping at some of the offsets alone."""
    for test, branch in enumerate(branches):
        step = float(np.ptp(WINDOW)) / (points - 1)
        for offset in np.linspace(-0.5, 0.5, 7) * step:
            window = (WINDOW[0] + offset, WINDOW[1] + offset)
            there = replace(branch, condition=replace(branch.condition, window=window))
            run = swept_run(there, test, 1, np.zeros(2), 0.0, np.random.default_rng(0), points)
            measured = tops_of_run(run, (0, 1))
            swept = swept_branch(branch, [run], 0)
            model = swept.tops_as_measured(run, (0, 1))
            np.testing.assert_allclose(model.value[:2], measured.value[:2], atol=0.05 * swept.half_width(0))
            np.testing.assert_allclose(model.value[2:], measured.value[2:], atol=1e-3)
            np.testing.assert_allclose(model.loss_factor, measured.loss_factor, rtol=0.01)


def of(found: tuple[PeakMisfit, ...], kind: type[Direction]) -> list[PeakMisfit]:
    return [m for m in found if isinstance(m.direction, kind)]


def test_nothing_is_said_of_the_model_that_made_the_runs(plans, branches) -> None:
    for plan in plans:
        found = misfits(plan, branches)
        assert len(of(found, Frequency)) == len(of(found, Amplitude)) == len(of(found, SensorGain)) == 3
        assert peak_findings(found, plan, NAMES) == ()


def test_significances_are_those_of_the_scatter(plans, branches) -> None:
    """Levels move together, so there are few independent draws of each."""
    for kind in (Frequency, Amplitude, SensorGain):
        sizes = np.array([m.significance for plan in plans for m in of(misfits(plan, branches), kind)])
        assert 0.2 < np.sqrt(np.mean(sizes**2)) < 2.0, kind


def test_a_peak_that_is_lower_at_one_level_is_read_and_named(plans, branches) -> None:
    plan = changed(plans[0], lambda o: np.array([0.0, -0.2, 0.0, -0.2, 0.0]) * (o.test == 2))
    said = peak_findings(misfits(plan, branches), plan, NAMES)
    assert [(f.quantity, f.level) for f in said] == [(Amplitude.quantity, 6.0)]
    assert said[0].relative == pytest.approx(np.expm1(0.2), abs=0.04)
    assert said[0].text.startswith("first: peak 2")
    numbers, others = said[0].text.split(" high at 6 N, ")
    assert numbers.count("%") == 1
    assert "4 N" in others
    assert "right at" in others


def test_a_resonance_that_shifts_with_the_level_is_read_against_the_other_levels(plans, branches) -> None:
    plan = changed(plans[0], lambda o: np.array([0.003 * (o.test == 2), 0, 0, 0, 0]))
    before, after = (of(misfits(p, branches), Frequency) for p in (plans[0], plan))
    assert after[2].relative - before[2].relative == pytest.approx(-0.003, abs=1e-5)
    said = peak_findings(misfits(plan, branches), plan, NAMES)
    assert (said[0].quantity, said[0].level) == (Frequency.quantity, 6.0)
    assert "low at 6 N" in said[0].text


def test_a_sensor_that_reads_high_in_all_runs_is_one_sentence(plans, branches) -> None:
    plan = changed(plans[1], lambda _: np.array([0.0, 0.1, 0.0, 0.0, 0.0]))
    (said,) = [f for f in peak_findings(misfits(plan, branches), plan, NAMES) if f.quantity == SensorGain.quantity]
    assert (said.level, said.channel) == (None, "a")
    assert said.text.startswith("first: a over b ")
    assert said.text.endswith("low at every force level")
    assert said.relative == pytest.approx(np.expm1(-0.1), abs=0.01)


def test_runs_that_end_below_the_top_are_held_against_their_repeats_alone(plans, branches) -> None:
    """Each assembly's sweep falls off the branch elsewhere on the way up: how high it came is no peak's height."""

    def ended(o: Observations) -> Observations:
        if o.test != 2:
            return o
        top = int(np.argmax(o.observed[:, 1]))
        kept = slice(0, top - 3 - 2 * o.repeat)
        return replace(o, observed=o.observed[kept], own=o.own[kept], log_force=o.log_force[kept])

    plan = replace(plans[0], observations=tuple(ended(o) for o in plans[0].observations))
    found = misfits(plan, branches)
    (height,) = [m for m in of(found, Amplitude) if m.direction.test == 2]
    assert height.relative > 0.1
    assert abs(height.significance) < 3.5
    assert all(m.direction.test != 2 or abs(m.significance) < 3.5 for m in found)
    assert peak_findings(found, plan, NAMES) == ()
    # the other levels are held against each other as before
    for kind in (Frequency, Amplitude, SensorGain):
        assert len(of(found, kind)) == 3


@pytest.mark.parametrize(("t", "deviations"), [(9.925, 2.576), (22.33, 3.090)])
def test_a_mean_of_few_repeats_is_as_unlikely_as_students_t_has_it(t: float, deviations: float) -> None:
    """Of three repeats: 1 in 200 and 1 in 1000 to one side (tables of Student's t with two degrees of freedom)."""
    spread = np.sqrt(3) / t
    assert by_repeats(1 + spread * np.array([-1.0, 0.0, 1.0])) == pytest.approx(deviations, abs=0.003)
    assert by_repeats(np.array([0.5, np.nan])) == 0  # one tells nothing of its spread


def test_force_as_measured_is_what_the_model_is_held_at(plans, branches) -> None:
    """Runs at 2 % less force than the condition's, recorded as such, are what the model expects there."""
    share = -0.02
    plan = synthetic_plan(
        parametrisation(), NONE, tuple(replace(c, force=c.force * np.exp(share)) for c in CONDITIONS), SCATTER, 0
    )[0]
    runs = tuple(replace(o, log_force=np.full(len(o), share)) for o in plan.observations)
    lower, usual = (misfits(p, branches) for p in (Plan(CONDITIONS, runs), plans[0]))
    for a, b in zip(lower, usual, strict=True):
        if not isinstance(a.direction, Damping):
            assert np.log1p(a.relative) - np.log1p(b.relative) == pytest.approx(0, abs=4e-3)


def test_a_model_without_a_peak_in_the_window_is_said_to_have_none(plans, branches) -> None:
    """Runs as if measured on the upper flank alone: there is nothing to read at that level, but at the others."""
    flank = (42.6, 43.2)
    high = trace_branch(parametrisation(), NONE, replace(CONDITIONS[2], window=flank))
    plan = replace(plans[0], conditions=(*CONDITIONS[:2], high.condition))
    there = (*branches[:2], high)
    assert without_peak(plans[0], branches) == ()
    assert without_peak(plan, there) == (2,)
    assert {m.direction.test for m in misfits(plan, there)} == {0, 1}
    (said,) = without_peak_findings((2,), plan)
    assert said.text == "first: the model has no peak where it was measured, at 6 N"


def test_what_the_fit_took_for_scatter_does_not_hide_a_shift_that_all_repeats_have(plans, branches) -> None:
    """Of a frequency that is too high in every run at one level, the fit takes some for a drift from run to run."""
    plan = changed(plans[0], lambda o: np.array([2e-3 * (o.test == 2), 0, 0, 0, 0]))
    too_large = replace(KNOWN, drift=2e-3)
    compared = compare_at(parametrisation(), NONE, plan, branches, too_large)
    fit = Fit(parametrisation(), compared, 1e-12 * np.eye(4), "")
    assert peak_findings(peak_misfits(fit, plan, branches), plan, NAMES) == ()
    (told,) = peak_findings(misfits(plan, branches), plan, NAMES)
    assert [f.text for f in all_findings(fit, plan, branches, (), NAMES, (), (), of_repeats(fit, plan))] == [told.text]
    silent = compare_at(parametrisation(), NONE, plans[0], branches, too_large)
    quiet = replace(fit, compared=silent)
    assert all_findings(quiet, plans[0], branches, (), NAMES, (), (), of_repeats(quiet, plans[0])) == ()


# Resonances read off curves are those of the oscillator that made them.


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("loss_factor", "points"), [(0.003, 41), (0.003, 201), (0.014, 21), (0.014, 201)])
def test_of_a_linear_oscillator(loss_factor: float, sign: int, points: int) -> None:
    """At the driving point or opposite to it, swept either way; at least five points in the width of the resonance."""
    f = np.linspace(79.07, 81.0, points)[::sign]
    receptance = sign * 0.5 / ((2 * np.pi * 80) ** 2 * (1 + 1j * loss_factor) - (2 * np.pi * f) ** 2)
    found = read_resonance(f, receptance, np.full(points, 3.0))
    assert found.loss_factor == pytest.approx(loss_factor, rel=0.02)
    assert found.frequency == pytest.approx(80, abs=0.03)
    assert found.receptance == pytest.approx(0.5 / ((2 * np.pi * 80) ** 2 * loss_factor), rel=0.03)
    assert found.amplitude == pytest.approx(3 * found.receptance)


def test_no_damping_is_told_where_the_phase_does_not_turn_as_an_oscillator_does() -> None:
    """Height flattened at the top, phase as it was: the width tells another damping than the phase."""
    f = np.linspace(79.0, 81.0, 201)
    receptance = 0.5 / ((2 * np.pi * 80) ** 2 * (1 + 0.003j) - (2 * np.pi * f) ** 2)
    size = np.abs(receptance)
    flat = receptance / np.sqrt(1 + (size / (0.5 * size.max())) ** 2)
    assert np.isnan(read_resonance(f, flat, np.ones(201)).loss_factor)
    assert read_resonance(f, flat, np.ones(201)).frequency == pytest.approx(80, abs=0.02)


@pytest.mark.parametrize("reach", [2.0, 0.6], ids=["both flanks", "one flank hardly"])
def test_damping_is_known_as_well_as_is_said(reach: float) -> None:
    """Read off one flank and a top that is hardly passed, it is far worse known than the height."""
    rng, noise, half_width = np.random.default_rng(11), 0.003, 0.25
    f = 50.0 + half_width * np.linspace(-reach, 2.0, 14)
    exact = np.log(1 / (50.0 - f + 1j * half_width))
    observed = np.column_stack([np.log(f), exact.real, exact.imag])
    run = Observations("run", 0, 1, observed, np.tile([1e-6, noise, noise], (14, 1)), np.zeros(14))
    drawn = exact + noise * (rng.standard_normal((400, 14)) + 1j * rng.standard_normal((400, 14)))
    read = np.log([loss_by_phase(f, np.exp(each), highest(each.real)) for each in drawn])
    assert np.std(read) == pytest.approx(damping_noise(run, [0])[0], rel=0.15)
