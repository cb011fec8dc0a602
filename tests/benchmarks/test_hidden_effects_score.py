"""Scoring, on verdicts made up for the purpose."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import typer

from updamp.benchmarks.hidden_effects import score, score_version_2
from updamp.benchmarks.hidden_effects.cases import Case
from updamp.benchmarks.hidden_effects.confusion import confusion
from updamp.benchmarks.hidden_effects.goals import OUTSIDE, goal
from updamp.benchmarks.hidden_effects.judgement import Called, judged
from updamp.benchmarks.hidden_effects.kinds_of_test import KINDS_OF_TEST
from updamp.benchmarks.hidden_effects.layout import Layout, write_whole
from updamp.benchmarks.hidden_effects.make_data import truth_of
from updamp.benchmarks.hidden_effects.score import all_goals, put_into, score_all
from updamp.benchmarks.hidden_effects.version_1 import version_1
from updamp.benchmarks.hidden_effects.version_2 import version_2
from updamp.diagnosis.verdict import VERDICT_JSON, Candidate, Confounding, ErrorReached, FittedParameter, Verdict
from updamp.effects.catalogue import CATALOGUE

PERFECT = ErrorReached(before=10.0, after=1.1, held_out_before=8.0, held_out_after=1.2, repeatability=1.0)
IDENTIFIED, INSEPARABLE = "identified", "inseparable"


@pytest.mark.parametrize(
    ("kind", "truth", "called", "mark"),
    [
        ("single", "a", Called(IDENTIFIED, ("a",)), "right"),
        ("single", "a", Called(IDENTIFIED, ("a",), ("a", "b", "c")), "right"),
        ("single", "a", Called(IDENTIFIED, ("b",)), "wrong"),
        ("single", "a", Called(IDENTIFIED, ("a", "b")), "wrong"),
        ("single", "a", Called(IDENTIFIED), "wrong"),
        ("single", "a", Called(INSEPARABLE, (), ("a", "b")), "right group"),
        ("single", "a", Called(INSEPARABLE, ("b",), ("a", "b")), "right group"),
        ("single", "a", Called(INSEPARABLE, (), ("a", "b", "c")), "wide group"),
        ("single", "a", Called(INSEPARABLE, (), ("b", "c")), "wrong"),
        ("single", "a", Called(INSEPARABLE, ("d",), ("a", "b")), "wrong"),
        ("single", "a", Called("adequate"), "missed"),
        ("single", "a", Called("unknown"), "unknown"),
        ("single", "a", Called("undecidable"), "undecided"),
        ("none", "", Called("adequate"), "right"),
        ("none", "", Called("undecidable"), "undecided"),
        ("none", "", Called("unknown"), "false alarm"),
        ("none", "", Called(INSEPARABLE, (), ("a", "b")), "false alarm"),
        ("outside", "x", Called("unknown"), "right"),
        ("outside", "x", Called(IDENTIFIED, ("a",)), "wrong"),
        ("outside", "x", Called(IDENTIFIED, ("x",)), "right"),
        ("outside", "x", Called(IDENTIFIED, ("x", "a")), "wrong"),
        ("outside", "x", Called(INSEPARABLE, (), ("x", "a")), "right group"),
        ("outside", "x", Called("undecidable"), "undecided"),
        ("outside", "x", Called("adequate"), "missed"),
        ("pair", "a b", Called(IDENTIFIED, ("b", "a")), "right"),
        ("pair", "a b", Called(IDENTIFIED, ("b",)), "partly"),
        ("pair", "a b", Called(IDENTIFIED, ("b", "c")), "wrong"),
        ("pair", "a b", Called(INSEPARABLE, ("a",), ("b", "c")), "right group"),
        ("pair", "a b", Called(INSEPARABLE, (), ("b", "c")), "partly"),
        ("pair", "a b", Called(INSEPARABLE, (), ("a", "b")), "partly"),
        ("pair", "a b", Called(INSEPARABLE, ("a",), ("c", "d")), "wrong"),
        ("pair", "a b", Called("unknown"), "unknown"),
        ("resolution", "", Called("adequate"), "right"),
    ],
)
def test_rules(kind, truth, called, mark):
    assert judged(kind, truth.split(), called) == mark


def test_verdict_that_there_is_not_is_refused():
    with pytest.raises(ValueError, match="'perhaps'"):
        judged("single", ["a"], Called("perhaps"))


def test_intervals_are_those_of_the_books():
    none = goal("", "", [False] * 24, lambda k, n: k * 24 <= n)
    assert none.exact == pytest.approx((0, 1 - 0.025 ** (1 / 24)))
    some = goal("", "", [True] * 11 + [False], lambda k, n: 12 * k >= 11 * n)
    z, p, n = 1.959964, 11 / 12, 12
    middle, half = p + z**2 / (2 * n), z * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    assert some.wilson == pytest.approx(((middle - half) / (1 + z**2 / n), (middle + half) / (1 + z**2 / n)), rel=1e-5)
    assert (some.count, some.of, some.met, none.met) == (11, 12, True, True)
    assert goal("", "", [True] * 10 + [False] * 2, lambda k, n: 12 * k >= 11 * n).met is False
    assert goal("", "", [], lambda k, n: k == n).met is None


def candidate(name: str, case: Case, off: float = 0.0, size: float = 40.0) -> Candidate:
    """off: of the parameters, relative; their intervals are 10 % to either side"""
    parameters = tuple(
        FittedParameter(
            p.name, p.unit, (1 + off) * v, *sorted(((0.9 + off) * v, (1.1 + off) * v)), p.null, p.lower, p.upper
        )
        for p in CATALOGUE[name].parameters
        if (v := case.catalogue_values.get(name, {}).get(p.name)) is not None
    )
    return Candidate(name, "", size, 0.5, 0.0, 0.0, 20.0, 0.5, parameters, True, "")


def verdict(called: Called, candidates: tuple[Candidate, ...] = (), error: ErrorReached = PERFECT) -> Verdict:
    nothing = Confounding((), np.zeros((0, 0)), 0.9, ())
    return Verdict(
        called.verdict, "", called.effects, called.group, candidates, error, (), (), nothing, (), (), {}
    )  # fmt: skip


def truly(case: Case) -> Called:
    if not case.hidden:
        return Called("adequate")
    return Called(IDENTIFIED, case.effects) if case.in_catalogue else Called("unknown")


def store(layout: Layout, case: Case, what: Verdict, seconds: float = 100.0) -> None:
    write_whole(layout.truth(case.name), truth_of(case, {}, 10.0))
    folder = layout.verdict(case.name)
    folder.mkdir(parents=True)
    VERDICT_JSON.write(folder / "diagnosis.json", what)
    write_whole(folder / "run.json", {"case": case.name, "seconds": seconds})


@pytest.fixture
def all_right(tmp_path: Path) -> Layout:
    """Every case with the verdict that it deserves."""
    layout = Layout(tmp_path)
    for case in version_1():
        candidates = tuple(candidate(name, case) for name in case.effects if name in CATALOGUE)
        store(layout, case, verdict(truly(case), candidates))
    return layout


def replaced(layout: Layout, case: Case, what: Verdict) -> None:
    VERDICT_JSON.write(layout.verdict(case.name) / "diagnosis.json", what)


def counts(layout: Layout) -> dict[str, tuple[int, int, bool | None]]:
    return {g.name: (g.count, g.of, g.met) for g in all_goals(score_all(layout)[0])}


def of_kind(kind: str) -> list[Case]:
    return [case for case in version_1() if case.kind == kind]


def test_where_all_is_right_every_goal_is_met(all_right: Layout) -> None:
    found = counts(all_right)
    assert all(met for _, _, met in found.values())
    assert [n for _, n, _ in found.values()] == [48, 48, 24, 12, 12, 3, 16, 16, 16, 16, 16, 96]
    assert found["false alarms where nothing is hidden"][0] == 0


def test_each_failure_counts_where_it_belongs(all_right: Layout) -> None:
    first, second, third, *_ = of_kind("single")
    wrong = "velocity_dependent_friction" if first.effects[0] != "velocity_dependent_friction" else "edge_gap"
    for case, called in (
        (first, Called(IDENTIFIED, (wrong,))),
        (second, Called("adequate")),
        (of_kind("none")[1], Called("unknown")),
        (of_kind("none")[2], Called(IDENTIFIED, ("edge_gap",))),
        (of_kind("outside")[0], Called(IDENTIFIED, ("edge_gap",))),
        (of_kind("pair")[0], Called(IDENTIFIED, of_kind("pair")[0].effects[:1])),
        (of_kind("resolution")[1], Called("unknown")),
    ):
        seen = tuple(candidate(name, case) for name in case.effects if name in CATALOGUE)
        replaced(all_right, case, verdict(called, seen))
    # not detectable, so that its miss does not count
    replaced(all_right, third, verdict(Called("adequate"), (candidate(third.effects[0], third, size=3.0),)))
    found = counts(all_right)
    assert found["right effect, or its group of two, of detectable single ones"] == (45, 47, True)
    assert found["confidently wrong, of detectable single ones"] == (1, 47, False)
    assert found["false alarms where nothing is hidden"] == (2, 24, False)
    assert found[OUTSIDE] == (11, 12, True)
    assert found["both of two effects"] == (11, 12, True)
    assert found["same verdict at 146 patches"] == (2, 3, False)


def test_a_law_that_the_catalogue_has_got_since_may_be_named_or_unknown(all_right: Layout) -> None:
    one, other = [case for case in of_kind("outside") if case.effects == ("quadratic_damping",)][:2]
    replaced(
        all_right, one, verdict(Called(IDENTIFIED, ("power_law_damping",)), (candidate("power_law_damping", one),))
    )
    replaced(all_right, other, verdict(Called(IDENTIFIED, ("material_damping",))))
    found = {c.case: c for c in score_all(all_right)[0]}
    assert (found[one.name].mark, found[other.name].mark) == ("right", "wrong")
    assert found[one.name].truth == ("quadratic_damping",)
    assert found[one.name].detectable
    # its exponent is at the null value, by which no error can be measured
    assert [r.name for r in found[one.name].recovered] == ["force"]
    assert counts(all_right)[OUTSIDE] == (11, 12, True)
    matrix = confusion(list(found.values()))
    row = matrix.rows.index("quadratic_damping")
    assert matrix.count[row, matrix.columns.index("power_law_damping")] == 1


def test_gains_and_parameters_of_strong_effects(all_right: Layout) -> None:
    one, other, third = [case for case in of_kind("single") if case.strength == "strong"][:3]
    off = candidate(one.effects[0], one, off=0.3)
    replaced(all_right, one, verdict(truly(one), (off,), replace(PERFECT, after=3.0)))
    near = candidate(other.effects[0], other, off=-0.12)
    replaced(all_right, other, verdict(truly(other), (near,), replace(PERFECT, held_out_after=float("nan"))))
    replaced(all_right, third, verdict(truly(third), (candidate(third.effects[0], third),), replace(PERFECT, before=4)))
    found = counts(all_right)
    assert found["strong: error 5 times lower"][0] == 14
    assert found["strong: error on held-out data 3 times lower"][0] == 15
    assert found["strong: final error at most 1.3 times repeatability"][0] == 15
    assert found["strong: parameters within 15 % of the truth"][0] == 15
    assert found["strong: parameters' 95 % intervals hold the truth"][0] == 14


def test_laboratory_s_expectation_decides_what_is_detectable(all_right: Layout) -> None:
    case, stale = of_kind("single")[:2]
    low = {case.effects[0]: {"score": 50.0, "visibility": 0.1}}
    write_whole(all_right.expected(case.name), {"case": case.name, "digest": case.digest, "effects": low})
    write_whole(all_right.expected(stale.name), {"case": stale.name, "digest": "of old data", "effects": {}})
    scored = {c.case: c for c in score_all(all_right)[0]}
    assert (scored[case.name].detectable, scored[case.name].detectable_by_diagnosis) == (False, True)
    assert scored[stale.name].detectable is True
    assert counts(all_right)["confidently wrong, of detectable single ones"][1] == 47


def test_ablations_from_the_sidecar_and_from_the_provenance(all_right: Layout) -> None:
    case, other = of_kind("single")[:2]
    sidecar = {"score only": {"verdict": "unknown"}, "BIC only": {"verdict": IDENTIFIED, "effects": case.effects}}
    write_whole(all_right.verdict(case.name) / "ablations.json", sidecar)
    said = json.dumps({"verdict": "inseparable", "effects": [], "group": [*other.effects, "x"]})
    replaced(all_right, other, replace(verdict(truly(other)), provenance={"ablation no U": said, "mesh": "small"}))
    scored = {c.case: c for c in score_all(all_right)[0]}
    assert {n: mark for n, (_, mark) in scored[case.name].ablations.items()} == {
        "score only": "unknown", "BIC only": "right",
    }  # fmt: skip
    assert scored[other.name].ablations["no U"][1] == "right group"
    write_whole(all_right.verdict(case.name) / "ablations.json", {"score only": ["unknown"]})
    with pytest.raises(ValueError, match="'score only'"):
        score_all(all_right)


def empty_notes(folder: Path) -> Path:
    path = folder / "notes.md"
    path.write_text("\n".join(score.CASES))
    return path


def test_command_writes_results_picture_and_page(all_right: Layout, tmp_path: Path) -> None:
    page, out = tmp_path / "page.md", tmp_path / "results.json"
    page.write_text("# Page\n\nabove\n" + "\nwhat was there\n".join(score.RESULTS) + "\nbelow\n")
    notes = empty_notes(tmp_path)
    write_whole(all_right.verdict("case_001") / "ablations.json", {"no U": {"verdict": "unknown"}})
    layout_without = all_right.verdict("case_002") / "run.json"
    layout_without.unlink()
    score.main(all_right.folder, out, page, notes)
    text = page.read_text()
    assert text.startswith("# Page\n\nabove\n")
    assert text.endswith("\nbelow\n")
    assert "what was there" not in text
    assert "98 of 99 cases are scored" in text
    assert "| without a part of the method | whole | no U |" in text
    rows = [line for line in notes.read_text().splitlines() if line.startswith("| 0")]
    assert len(rows) == 98
    assert not any(line.startswith("| 0") for line in text.splitlines()), "the page has the goals alone"
    results = json.loads(out.read_text())
    assert len(results["cases"]) == 98
    assert results["without a verdict"] == ["case_002"]
    assert {"truth", "called", "mark", "error", "detectable", "seconds"} <= set(results["cases"][0])
    assert (tmp_path / "page.png").stat().st_size > 20_000
    with pytest.raises(ValueError, match="needs a line"):
        put_into("no marks", "")


def test_earlier_results_are_kept_beside_new_verdicts(all_right: Layout, tmp_path: Path) -> None:
    page, out = tmp_path / "page.md", tmp_path / "results.json"
    page.write_text("\n".join(score.RESULTS))
    notes = empty_notes(tmp_path)
    again, lost = of_kind("single")[:2]
    (all_right.verdict("case_099") / "run.json").unlink()
    score.main(all_right.folder, out, page, notes)
    before = json.loads(out.read_text())
    for path in all_right.truth("*").parent.glob("case_*.json"):
        path.unlink() if path.stem not in (again.name, lost.name) else None
    (all_right.verdict(lost.name) / "run.json").unlink()
    replaced(all_right, again, verdict(Called("unknown")))
    score.main(all_right.folder, out, page, notes, keep=True)
    after = json.loads(out.read_text())
    assert after["without a verdict"] == before["without a verdict"] == ["case_099"]
    changed = [a["case"] for a, b in zip(after["cases"], before["cases"], strict=True) if a != b]
    assert changed == [again.name]
    score.main(all_right.folder, out, page)
    assert len(json.loads(out.read_text())["cases"]) == 1


DRAW = 5


@pytest.fixture
def second(tmp_path: Path) -> Layout:
    """The first 100 cases of version 2 with the verdicts that they deserve; every effect can be seen but one kind."""
    layout = Layout(tmp_path)
    for case in version_2(DRAW)[:100]:
        candidates = tuple(candidate(name, case) for name in case.effects if name in CATALOGUE)
        store(layout, case, verdict(truly(case), candidates))
        seen = {name: {"score": 5.0 if name == "tip_stop" else 50.0, "visibility": 0.5} for name in case.effects}
        write_whole(layout.expected(case.name), {"digest": case.digest, "effects": seen})
    return layout


def scored_again(layout: Layout, folder: Path) -> dict[str, dict[str, int]]:
    page, out = folder / "page.md", folder / "results_v2.json"
    page.write_text("above\n" + "\n".join(score_version_2.MARKS))
    score_version_2.main(DRAW, layout.folder, out, page)
    assert "100 of 160 cases" in page.read_text()
    return json.loads(out.read_text())["counts"]


def test_the_second_version_is_counted_in_all_and_for_each_test(second: Layout, tmp_path: Path) -> None:
    found = scored_again(second, tmp_path)
    cases = version_2(DRAW)[:100]
    tests = {test: found.pop(test) for test in KINDS_OF_TEST}
    assert all(sum(one[name] for one in tests.values()) == n for name, n in found.items())
    assert found["cases"] == 100
    assert found["single"] == found["single_right"] == sum(c.kind == "single" for c in cases)
    outside = sum(c.kind == "outside" and c.effects != ("tip_stop",) for c in cases)
    assert found["outside"] == found["outside_right"] == outside
    assert found["confidently_wrong"] == found["false_alarms"] == 0
    assert found["intervals"] == found["intervals_hold"] > 0


def test_the_second_version_may_be_scored_in_parts(second: Layout, tmp_path: Path) -> None:
    """From session to session: what was scored is kept, by whatever commit; cases of another draw are not."""
    whole = scored_again(second, tmp_path)
    page, out = tmp_path / "page.md", tmp_path / "results_v2.json"
    before = json.loads(out.read_text())
    for path in second.verdict("*").parent.glob("case_*/run.json"):
        path.unlink()
    first = version_2(DRAW)[100]
    store(second, first, verdict(truly(first)))
    score_version_2.main(DRAW, second.folder, out, page, keep=True)
    after = json.loads(out.read_text())
    assert after["counts"]["cases"] == whole["cases"] + 1
    assert after["cases"][:100] == before["cases"]
    with pytest.raises(typer.BadParameter, match=f"draw {DRAW}, not {DRAW + 1}"):
        score_version_2.main(DRAW + 1, second.folder, out, page, keep=True)


def test_what_fails_in_the_second_version_counts_where_it_belongs(second: Layout, tmp_path: Path) -> None:
    before = scored_again(second, tmp_path)
    by_kind = {c.kind: c for c in version_2(DRAW)[:100] if c.test == "jumping" and c.effects != ("tip_stop",)}
    for case in by_kind.values():
        replaced(second, case, verdict(Called(IDENTIFIED, ("no_such",))))
    after = scored_again(second, tmp_path)
    assert set(by_kind) == {"none", "single", "outside", "pair"}
    for counts_of in ("jumping", None):
        was, now = (one[counts_of] if counts_of else one for one in (before, after))
        for right in ("single_right", "outside_right", "pairs_right"):
            assert now[right] == was[right] - 1
        assert (now["confidently_wrong"], now["false_alarms"]) == (3, 1)
    assert after["scarce"] == before["scarce"]


def test_confusion_counts_every_case_once(all_right: Layout) -> None:
    case = of_kind("single")[0]
    group = (case.effects[0], "edge_gap")
    replaced(all_right, case, verdict(Called(INSEPARABLE, (), group)))
    matrix = confusion(score_all(all_right)[0])
    assert dict(zip(matrix.rows, matrix.cases, strict=True))["nothing hidden"] == 24
    assert sum(matrix.cases) == 48 + 24 + 12
    np.testing.assert_allclose(matrix.count.sum(axis=1), matrix.cases)
    row = matrix.rows.index(case.effects[0])
    assert matrix.count[row, matrix.columns.index(case.effects[0])] == 2.5
    assert matrix.count[row, matrix.columns.index("edge_gap")] == 0.5
