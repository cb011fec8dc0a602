"""What is traced where one segment does not lead through the window, and whether a curve is complete."""

from dataclasses import replace

import numpy as np
import pytest
from support.peers import one_degree_of_freedom, solved

from updamp.hbm.contact.springs import CubicParameters, CubicSpring
from updamp.hbm.continuation import continuation, segments
from updamp.hbm.continuation.completeness import CompletenessLimits, half_width, shortcoming
from updamp.hbm.continuation.continuation import BranchStoppedError, ContinuationOptions, continue_branch, first_point
from updamp.hbm.continuation.curve import CurveRequest, trace
from updamp.hbm.continuation.curve_records import COLUMNS
from updamp.hbm.newton.newton import Status
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.system import Excitation

WINDOW = (0.5 / 2 / np.pi, 2.0 / 2 / np.pi)


def linear_oscillator():
    d = solved("a_duffing_1dof")["definition"]
    group = ElementGroup(CubicSpring(), CubicParameters(np.array([0.0])), np.array([[0]]))
    system = one_degree_of_freedom(d["c"], group, (0, 1), 16)
    return system, CurveRequest("1", Excitation(system.free.row("mass"), d["P"]), WINDOW, ("mass",))


def ending(place, from_starts=True):
    """`continue_branch` that stops where it comes into `place` [Hz]; from_starts: segments from starts inside the
    window too"""

    def followed(system, excitation, window, options, upwards, resume=()):
        for point in continue_branch(system, excitation, window, options, upwards, resume):
            if (from_starts or not resume) and place[0] < point.frequency < place[1]:
                raise BranchStoppedError(point.frequency, 1.0, Status.STALLED)
            yield point

    return followed


def test_what_stops_both_segments_is_passed_from_starts_between_them(monkeypatch):
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    monkeypatch.setattr(segments, "continue_branch", ending(np.quantile(WINDOW, (0.5, 0.6)), from_starts=False))
    *_, passed = trace(system, request)
    assert passed.complete
    assert not passed.after_gap.any()
    assert (np.diff(passed.frequency) > 0).all()
    assert passed.peak("mass") == pytest.approx(whole.peak("mass"), rel=1e-3)


def test_a_place_that_nothing_passes_makes_the_curve_incomplete(monkeypatch):
    """It holds the resonance: the largest point that was found is no peak, and the curve says so."""
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    at = whole.peak("mass")[0]
    monkeypatch.setattr(segments, "continue_branch", ending((0.9 * at, 1.1 * at)))
    *_, curve = trace(system, request)
    assert not curve.complete
    assert "not followed between" in curve.stopped
    assert curve.after_gap.any()
    assert (np.diff(curve.frequency) > 0).all(), "nothing is traced twice"
    assert curve.frequency[0] == pytest.approx(WINDOW[0])
    assert curve.frequency[-1] >= WINDOW[1]


def test_a_branch_that_comes_back_is_traced_from_the_other_end(monkeypatch):
    """A branch that turns round and leaves the window where it began is not the one that leads through it. It is met
    where it had not turned yet, and what it traced after that is left out.
    """
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    turn = np.quantile(WINDOW, 0.2)

    def turning(system, excitation, window, options, upwards, resume=()):
        points = []
        for point in continue_branch(system, excitation, window, options, upwards, resume):
            points.append(point)
            yield point
            if upwards and point.frequency > turn:
                below = next(continue_branch(system, excitation, (0.99 * window[0], window[1]), options))
                yield from (*points[-2::-1], below)
                return

    monkeypatch.setattr(segments, "continue_branch", turning)
    *_, curve = trace(system, request)
    assert curve.complete
    assert curve.frequency.max() >= WINDOW[1]
    assert not curve.after_gap.any()
    assert (np.diff(curve.frequency) > 0).all()
    assert abs(curve.peak("mass")[1] / whole.peak("mass")[1] - 1) < 1e-3


@pytest.mark.parametrize("upwards", [True, False])
def test_a_branch_is_led_into_the_window_where_its_end_has_no_first_point(monkeypatch, upwards):
    """First points are found only 0.15 of the window's width outside: the branch is handed out from the end on."""
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    width = WINDOW[1] - WINDOW[0]

    def far_out(system, excitation, w, options=None):
        if WINDOW[0] - 0.15 * width < w / 2 / np.pi < WINDOW[1] + 0.15 * width:
            raise BranchStoppedError(w / 2 / np.pi, 1.0, Status.STALLED)
        return first_point(system, excitation, w, options)

    monkeypatch.setattr(continuation, "first_point", far_out)
    points = list(continue_branch(system, request.excitation, WINDOW, upwards=upwards))
    frequency = np.array([point.frequency for point in points])[:: 1 if upwards else -1]
    assert (np.diff(frequency) > 0).all()
    assert WINDOW[0] - 0.1 * width < frequency[0] < WINDOW[0] or not upwards
    assert WINDOW[1] < frequency[-1] < WINDOW[1] + 0.1 * width
    *_, curve = trace(system, request)
    assert curve.complete
    assert abs(curve.peak("mass")[1] / whole.peak("mass")[1] - 1) < 1e-3


def test_where_no_point_is_found_at_all_the_curve_says_why(monkeypatch):
    system, request = linear_oscillator()

    def nowhere(_system, _excitation, w, _options=None):
        raise BranchStoppedError(w / 2 / np.pi, 1.0, Status.STALLED)

    monkeypatch.setattr(continuation, "first_point", nowhere)
    *_, curve = trace(system, request)
    assert len(curve) == 0
    assert not curve.complete
    assert "no branch was found" in curve.stopped
    assert Status.STALLED.advice in curve.stopped


def test_where_no_start_is_found_the_end_of_the_window_is_named(monkeypatch):
    system, request = linear_oscillator()

    def nowhere(_system, _excitation, w, _options=None):
        raise BranchStoppedError(w / 2 / np.pi, 1.0, Status.STALLED)

    monkeypatch.setattr(continuation, "first_point", nowhere)
    with pytest.raises(BranchStoppedError) as stop:
        next(iter(continue_branch(system, request.excitation, WINDOW)))
    assert stop.value.frequency == pytest.approx(WINDOW[0])


@pytest.mark.parametrize("upwards", [True, False])
def test_a_branch_begins_a_little_inside_where_its_end_has_no_first_point(monkeypatch, upwards):
    """First points are found from 0.02 of the window's width inside on, and nowhere outside."""
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    width = WINDOW[1] - WINDOW[0]

    def far_in(system, excitation, w, options=None):
        if not WINDOW[0] + 0.02 * width < w / 2 / np.pi < WINDOW[1] - 0.02 * width:
            raise BranchStoppedError(w / 2 / np.pi, 1.0, Status.STALLED)
        return first_point(system, excitation, w, options)

    monkeypatch.setattr(continuation, "first_point", far_in)
    points = list(continue_branch(system, request.excitation, WINDOW, upwards=upwards))
    left_out = points[0].frequency - WINDOW[0] if upwards else WINDOW[1] - points[0].frequency
    assert -0.1 * width < left_out <= 0
    *_, curve = trace(system, request)
    assert curve.complete
    assert abs(curve.peak("mass")[1] / whole.peak("mass")[1] - 1) < 1e-3


@pytest.mark.parametrize(("half_widths", "complete"), [(0.05, True), (0.3, False)])
def test_a_gap_below_a_tenth_of_the_half_width_is_none(half_widths, complete):
    """On the steepest part of the resonance, where the response changes by as much."""
    system, request = linear_oscillator()
    *_, whole = trace(system, replace(request, options=ContinuationOptions(first_step=0.01, largest_step=0.02)))
    frequency, size = whole.frequency, np.abs(whole.receptance("mass"))
    width = half_width(frequency, size)
    left = int(np.searchsorted(frequency, whole.peak("mass")[0]))
    right = int(np.searchsorted(frequency, frequency[left] + half_widths * width))
    kept = np.r_[: left + 1, right : len(frequency)]
    columns = {name: getattr(whole, name)[kept] for name in COLUMNS}
    columns["after_gap"] = kept == right
    cut = replace(whole, **columns)
    assert (shortcoming(cut, WINDOW, CompletenessLimits(), "mass") == "") == complete


@pytest.mark.parametrize("kept", [slice(40, None), slice(None, -40)])
def test_a_window_that_is_not_covered_is_named(kept):
    system, request = linear_oscillator()
    *_, whole = trace(system, replace(request, options=ContinuationOptions(first_step=0.01, largest_step=0.02)))
    cut = replace(whole, **{name: getattr(whole, name)[kept] for name in COLUMNS})
    assert "is covered to" in shortcoming(cut, WINDOW, CompletenessLimits(), "mass")


def test_a_branch_that_leaves_the_window_where_it_came_in_is_not_complete():
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    middle = whole.frequency.mean()
    back = replace(whole, frequency=np.append(whole.frequency[:-1], WINDOW[0]))
    assert "left the window where it had entered" in shortcoming(back, WINDOW, CompletenessLimits(), "mass")
    folded = replace(whole, frequency=middle - np.abs(whole.frequency - middle))
    assert "is covered to" in shortcoming(folded, WINDOW, CompletenessLimits(), "mass")


@pytest.mark.parametrize("window", [(0.5, 0.95), (1.05, 2.0)])
@pytest.mark.parametrize("upwards", [True, False])
def test_a_largest_response_at_the_end_of_the_window_is_no_peak(window, upwards):
    """The resonance, at 1 rad/s, lies beyond it."""
    system, request = linear_oscillator()
    *_, curve = trace(system, replace(request, window=tuple(w / 2 / np.pi for w in window), upwards=upwards))
    assert not curve.complete
    assert "its resonance does not lie within it: widen the window" in curve.stopped


@pytest.mark.parametrize(("mirrored", "remedy"), [(False, "raise the lower end"), (True, "lower the upper end")])
def test_a_neighbours_flank_at_the_end_of_the_window_is_told_from_a_resonance_beyond_it(mirrored, remedy):
    """Widened, the window would hold both, and the neighbour's peak be called that of the resonance meant."""
    system, request = linear_oscillator()
    *_, whole = trace(system, request)
    assert shortcoming(whole, WINDOW, CompletenessLimits(), "mass") == ""
    size = np.abs(whole.receptance("mass"))
    top, at = size.max(), whole.frequency[size.argmax()]
    end = whole.frequency.max() if mirrored else whole.frequency.min()
    flank = 2 * top * np.exp(-np.abs(whole.frequency - end) / (0.05 * np.ptp(WINDOW)))
    factor = 1 + flank / np.abs(whole.receptance("mass"))
    beside = replace(whole, response=whole.response * factor[:, np.newaxis, np.newaxis])
    said = shortcoming(beside, WINDOW, CompletenessLimits(), "mass")
    assert f"a maximum at {at:.6g} Hz within it" in said
    assert remedy in said


def two_branches(seen):
    """`continue_branch` whose branch from the lower end of the window turns and leaves it there, another one than that
    from the upper end, which leaves at the lower end too. seen: the starts that it was given"""

    def followed(system, excitation, window, options, upwards, resume=()):
        seen.extend(resume)
        points = []
        for point in continue_branch(system, excitation, window, options, upwards, resume):
            points.append(point if upwards else replace(point, x=3 * point.x))
            yield points[-1]
            if upwards and point.frequency > np.quantile(window, 0.2):
                below = next(continue_branch(system, excitation, (0.9 * window[0], window[1]), options))
                yield from (*points[-2::-1], below)
                return

    return followed


def test_where_the_branch_leaves_the_window_nothing_of_it_is_missing(monkeypatch):
    """But what comes back there need not be the same branch, so that the curve is not complete."""
    system, request = linear_oscillator()
    starts = []
    monkeypatch.setattr(segments, "continue_branch", two_branches(starts))
    *_, curve = trace(system, request)
    assert not curve.complete
    assert starts == [], "there is nothing to be found between the ends"
    assert "not followed" not in curve.stopped
    assert (
        f"the branch leaves the window from {WINDOW[0]:.4g} to {WINDOW[1]:.4g} Hz at {WINDOW[0]:.4g} Hz"
        in curve.stopped
    )
    assert "widen the window" in curve.stopped
    assert "Hz: it left the window" in curve.stopped
    assert "it left the window at" not in curve.stopped, "a frequency is named once"


def test_half_width_of_a_linear_resonance_is_that_of_its_damping():
    frequency, ratio = np.linspace(0.9, 1.1, 2001), 0.01
    size = 1 / np.abs(1 - frequency**2 + 2j * ratio * frequency)
    assert half_width(frequency, size) == pytest.approx(ratio, rel=0.05)
    assert half_width(frequency[:1001], size[:1001]) == pytest.approx(ratio, rel=0.05)


@pytest.mark.parametrize("offset", np.linspace(0, 1, 7))
def test_half_width_does_not_depend_on_where_the_points_lie(offset):
    """A phase of 0.2 rad from point to point, the longest step there is, and one point at the top."""
    ratio = 0.01
    phase = np.union1d(np.arange(-1.4, 1.4, 0.2) + 0.2 * offset, 0.0)
    frequency = 1 + ratio * np.tan(phase)
    assert half_width(frequency, np.cos(phase)) == pytest.approx(ratio, rel=0.02)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"window": WINDOW[::-1]}, "a lower and a higher frequency are needed"),
        ({"window": (0.1, 0.1)}, "a lower and a higher frequency are needed"),
        ({"window": (0.0, 0.1)}, "above 0"),
        ({"window": (np.nan, 0.1)}, "window = nan to 0.1 Hz"),
        ({"force": 0.0}, "force = 0 N"),
        ({"force": -1.0}, "force = -1 N"),
        ({"force": np.nan}, "force = nan N"),
        ({"points": ()}, "points: at least one"),
        ({"told": "tip"}, r"told = 'tip': a tuple of names is needed, such as \('tip',\)"),
        ({"points": "mass"}, r"points = 'mass': a tuple of names is needed"),
        ({"told": ("elsewhere",)}, "told: 'elsewhere' is not observed"),
    ],
)
def test_what_no_curve_can_be_asked_for_is_refused(given, said):
    _, request = linear_oscillator()
    force = {"excitation": replace(request.excitation, force=given["force"])} if "force" in given else {}
    with pytest.raises(ValueError, match=said):
        replace(request, **({key: value for key, value in given.items() if key != "force"} | force))


def test_a_low_frequency_is_told_with_its_digits():
    """Of a slow structure two decimals say nothing."""
    system, request = linear_oscillator()
    *_, curve = trace(system, replace(request, window=(1e-3, 2e-3)))
    assert "is largest at 0.002" in curve.stopped
    assert "from 0.001 to 0.002 Hz" in curve.stopped
