"""The blind benchmark's cases and data: how many of what, and that a measurement does not give its truth away."""

import json
from collections import Counter
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import TINY

from updamp.benchmarks.hidden_effects import cases as hidden_effects_cases
from updamp.benchmarks.hidden_effects.cases import Case, chosen
from updamp.benchmarks.hidden_effects.in_turn import in_turn
from updamp.benchmarks.hidden_effects.kinds_of_test import EASY, KINDS_OF_TEST, KindOfTest
from updamp.benchmarks.hidden_effects.layout import Layout, read
from updamp.benchmarks.hidden_effects.make_data import is_made, make_case
from updamp.benchmarks.hidden_effects.version_1 import NULLS, OUTSIDE, PAIRS, SINGLES, version_1
from updamp.benchmarks.hidden_effects.version_2 import drawn, version_2
from updamp.benchmarks.virtual_rig.bench import STRENGTHS
from updamp.benchmarks.virtual_rig.bodies import bodies_of
from updamp.benchmarks.virtual_rig.laboratory import HIDDEN, hidden
from updamp.benchmarks.virtual_rig.plan import PlannedRun, TestPlan
from updamp.effects.catalogue import CATALOGUE
from updamp.measurement.load import load_measurement
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig

PLAN = TestPlan((PlannedRun("IP", 0.5), PlannedRun("OOP", 2.0)), 2, 8)
RIG = Path(__file__).parents[2] / "rigs" / "virtual_rig.toml"


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> object:
    """The laboratory's own store of finite elements is left alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hidden_effects_cases, "KINDS_OF_TEST", {EASY.name: KindOfTest(EASY.name, RIG, PLAN, EASY.noise)})
        patch.setattr(bodies_of, "__defaults__", (tmp_path_factory.mktemp("kept"),))
        yield load_rig(RIG, {"mesh.tiny": TINY, "reduction.modes": 10})


def test_cases_are_as_many_as_asked_for() -> None:
    found = version_1()
    assert Counter(c.kind for c in found) == {"single": 48, "none": 24, "outside": 12, "pair": 12, "resolution": 3}
    singles = {(c.effects[0], c.strength) for c in found if c.kind == "single"}
    assert singles == {(name, strength) for name in SINGLES for strength in STRENGTHS}
    assert set(SINGLES) <= set(CATALOGUE)
    outside = {c.effects[0] for c in found if c.kind == "outside"}
    assert outside == {name for name, _ in OUTSIDE}
    pairs = [set(c.effects) for c in found if c.kind == "pair"]
    assert all(len(pair) == 2 and pair <= set(CATALOGUE) for pair in pairs)
    assert len({frozenset(pair) for pair in pairs}) == len(PAIRS) == 12


def test_order_begins_with_what_the_method_is_worked_out_with() -> None:
    kinds = [(c.kind, c.strength) for c in version_1()]
    assert kinds[:12] == [("none", "")] * 12
    assert kinds[12:44] == [("single", "strong")] * 16 + [("single", "medium")] * 16
    assert kinds[-28:] == [("none", "")] * (NULLS - 12) + [("single", "weak")] * 16


def test_numbers_and_seeds_are_each_case_s_own_and_tell_nothing() -> None:
    found = version_1()
    assert sorted(c.number for c in found) == list(range(1, 100))
    assert len({c.seed for c in found if not c.repeats}) == 96
    nothing = np.array([c.kind == "none" for c in sorted(found, key=lambda c: c.number)])
    assert abs(np.corrcoef(np.arange(99), nothing)[0, 1]) < 0.2
    assert [c.name for c in found] == [c.name for c in version_1()]


def test_repetitions_have_the_draws_of_what_they_repeat() -> None:
    known = {c.number: c for c in version_1()}
    for case in chosen(version_1(), ("resolution",)):
        original = known[case.repeats]
        assert (case.hidden, case.seed) == (original.hidden, original.seed)
        assert (case.laboratory, case.fitted) == ("laboratory", "diagnosis_146")
        assert (original.laboratory, original.fitted) == ("laboratory", "diagnosis")
        assert case.digest != original.digest


def test_the_second_version_has_every_kind_in_every_test_and_tells_nothing() -> None:
    found = version_2(7)
    assert found == version_2(7)
    assert not {c.digest for c in found} & {c.digest for c in version_2(8)}
    assert [c.number for c in found] == list(range(1, 161))
    assert len({c.seed for c in found}) == 160
    by_test = {test: Counter(c.kind for c in found if c.test == test) for test in KINDS_OF_TEST}
    assert all((n["single"], n["outside"], n["pair"]) == (24, 8, 8) for n in by_test.values())
    assert sum(n["none"] for n in by_test.values()) == 40
    inside = {name for name, effect in HIDDEN.items() if effect.in_catalogue}
    for test in KINDS_OF_TEST:
        assert {c.effects[0] for c in found if (c.test, c.kind) == (test, "single")} == inside
    nothing = np.array([c.kind == "none" for c in found])
    assert abs(np.corrcoef(np.arange(160), nothing)[0, 1]) < 0.2


@pytest.mark.parametrize("name", HIDDEN)
def test_drawn_strengths_lie_between_weak_and_strong_of_either_sign(name: str) -> None:
    rng = np.random.default_rng(3)
    weak, strong = (HIDDEN[name].strengths[s] for s in ("weak", "strong"))
    all_drawn = [drawn(name, rng) for _ in range(60)]
    assert {one.strength for one in all_drawn} == set(STRENGTHS)
    known = CATALOGUE[name].parameters if name in CATALOGUE else ()
    bounds = {q.name: (q.lower, q.upper) for q in known}
    for one in all_drawn:
        for q, value in one.values.items():
            ends = sorted((weak[q], strong[q]))
            mirrored = (ends[0] <= -value <= ends[1]) or (ends[0] <= 1 / value <= ends[1])
            assert ends[0] * (1 - 1e-12) <= value <= ends[1] * (1 + 1e-12) or mirrored
            assert bounds.get(q, (-np.inf, np.inf))[0] <= value <= bounds.get(q, (-np.inf, np.inf))[1]


def test_cases_are_chosen_by_name_kind_strength_and_effect() -> None:
    assert {c.strength for c in chosen(version_1(), ("strong",))} == {"strong"}
    assert {c.effects for c in chosen(version_1(), ("edge_gap",)) if c.kind == "single"} == {("edge_gap",)}
    assert {c.kind for c in chosen(version_1(), ("pair", "none"))} == {"pair", "none"}
    assert chosen(version_1(), ("case_007",))[0].number == 7
    with pytest.raises(ValueError, match="case_100"):
        chosen(version_1(), ("case_100",))


@pytest.mark.long
def test_measurement_does_not_give_its_truth_away(rig: Rig, tmp_path: Path) -> None:
    layout = Layout(tmp_path)
    case = Case(7, "single", (hidden("contact_viscosity", "strong"),), 5, "tiny")
    assert not is_made(case, layout)
    made = make_case(case, layout, rig)
    assert (made.points, made.planned) == (32, 32)
    assert is_made(case, layout)
    for path in layout.data("case_007").rglob("*"):
        assert path.name in ("measurement.toml", "sweeps.csv")
        text = path.read_text().lower()
        assert not [word for word in ("viscosity", "strong", "hidden", "seed", "single") if word in text], path
    assert len(load_measurement(layout.measurement("case_007")).runs) == 4


def test_truth_is_in_the_catalogue_s_terms(rig: Rig, tmp_path: Path) -> None:
    layout = Layout(tmp_path)
    make_case(Case(8, "outside", (hidden("quadratic_damping", "weak"),), 5, "tiny"), layout, rig)
    both = (hidden("edge_gap", "weak"), hidden("wire_stiffness", "weak"))
    make_case(Case(9, "pair", both, 6, "tiny"), layout, rig)
    outside, pair = (json.loads(layout.truth(f"case_00{n}").read_text()) for n in (8, 9))
    by_its_name = {"power_law_damping": {"force": pytest.approx(0.1), "exponent": 2}}
    assert (outside["effects"], outside["parameters"]) == (["quadratic_damping"], by_its_name)
    assert outside["in_catalogue"] is False
    assert Case(10, "outside", (hidden("tip_coupling", "weak"),), 5).catalogue_values == {}
    assert pair["parameters"] == {"edge_gap": {"depth": 5e-8}, "wire_stiffness": {"factor": 5}}
    assert len(pair["record"]["assemblies"]) == 2
    assert pair["record"]["seed"] == pair["seed"] == 6


def test_data_of_a_case_that_has_changed_are_made_again(rig: Rig, tmp_path: Path) -> None:
    layout = Layout(tmp_path)
    weak, strong = (Case(3, "single", (hidden("wire_stiffness", s),), 5, "tiny") for s in ("weak", "strong"))
    make_case(weak, layout, rig)
    first = (layout.data("case_003") / "sweeps.csv").read_text()
    assert not is_made(strong, layout)
    make_case(strong, layout, rig)
    assert is_made(strong, layout)
    assert not is_made(weak, layout)
    assert (layout.data("case_003") / "sweeps.csv").read_text() != first


@pytest.mark.parametrize("jobs", [1, 2])
def test_tasks_go_on_where_one_fails(jobs: int) -> None:
    good = version_1()[:3]
    assert sorted(in_turn(attrgetter("seed"), good, jobs, "working", str)) == sorted(c.seed for c in good)
    bad = (good[0], _Nameless("broken"), good[1])
    with pytest.raises(RuntimeError, match="broken: AttributeError"):
        in_turn(attrgetter("seed"), bad, 1, "working", str)


class _Nameless:
    def __init__(self, name: str) -> None:
        self.name = name


def test_a_file_that_is_not_json_is_named(tmp_path: Path) -> None:
    (tmp_path / "broken.json").write_text("{")
    with pytest.raises(ValueError, match=r"broken\.json.*delete it"):
        read(tmp_path / "broken.json")
    assert read(tmp_path / "absent.json") is None
