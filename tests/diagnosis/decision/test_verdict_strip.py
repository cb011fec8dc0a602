"""How the verdict hangs on the repeatability that was stated, from evidence made up."""

from dataclasses import replace

from updamp.diagnosis.criteria import Criteria
from updamp.diagnosis.decision.verdict_strip import strip
from updamp.diagnosis.evidence import EffectScore, Evidence, IfRepeatable, Trial

VALUES = 400


def stated(excess_at_one_percent: float) -> tuple[IfRepeatable, ...]:
    """A misfit of so many times 1 %, squared, whatever repeatability it is divided by."""
    return tuple(
        IfRepeatable(r, excess := excess_at_one_percent * (0.01 / r) ** 2, VALUES * excess, excess**0.5, excess)
        for r in (0.005, 0.01, 0.02, 0.04, 0.08)
    )


ONE = Trial(("slip",), 9.0, 0.0, 0.0, 3.0, "", True, if_repeatable=stated(9.0))
BOTH = Trial(("slip", "spring"), 2.0, 0.0, 0.0, 1.4, "", True, parameters=2, if_repeatable=stated(2.0))
EVIDENCE = Evidence(
    excess=40.0,
    held_out=40**0.5,
    repeatability=1.0,
    tested=tuple(EffectScore(name, 90.0, 0.8, 8100.0, 0.6, 200.0) for name in ("slip", "spring")),
    trials=(ONE,),
    combined=(BOTH,),
    alike=(),
    if_repeatable=stated(40.0),
    independent=VALUES / 10,
    unseen_independent=VALUES / 40,
    as_one=10.0,
)


def test_each_change_of_the_verdict_is_told() -> None:
    """Errors of 6.3 % without effects, 3 % with one and 1.4 % with two."""
    found = [(e.repeatability, e.verdict, e.effects) for e in strip(EVIDENCE, Criteria())]
    assert found == [
        (0.005, "unknown", ()),
        (0.02, "identified", ("slip", "spring")),
        (0.04, "identified", ("slip",)),
        (0.08, "adequate", ()),
    ]


def test_where_repeats_tell_there_is_none() -> None:
    trials = replace(ONE, if_repeatable=())
    assert strip(replace(EVIDENCE, if_repeatable=(), trials=(trials,), combined=()), Criteria()) == ()
