"""What is written comes back to the last digit, and a file that does not fit is refused by name."""

import json
import math
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.synthetic_comparison import features_only, synthetic_comparison
from support.synthetic_verdict import synthetic_verdict

from updamp.comparison.comparison import COMPARISON_JSON, Comparison
from updamp.comparison.json_document import decode, encode
from updamp.diagnosis.verdict import VERDICT_JSON


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    full = synthetic_comparison(levels=(0.96, 17.0), repeats=2, points=9)
    odd = replace(full.curves[0], band=np.zeros((0, 3)), frac=math.nan)
    infinite = replace(full.calibration[0], prior_deviation=math.inf, lower=-math.inf)
    return replace(full, curves=(odd, *full.curves[1:]), calibration=(infinite, *full.calibration[1:]))


def same(a: Any, b: Any) -> bool:
    """Equal in type, shape and every bit, nan equal to nan."""
    if type(a) is not type(b):
        return False
    if is_dataclass(a):
        return all(same(getattr(a, field.name), getattr(b, field.name)) for field in fields(a))
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and np.array_equal(a, b, equal_nan=a.dtype.kind in "fc")
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    return a == b or (isinstance(a, float) and math.isnan(a) and math.isnan(b))


def test_comparison_comes_back_from_its_file(comparison: Comparison, tmp_path: Path) -> None:
    path = tmp_path / "comparison.json"
    COMPARISON_JSON.write(path, comparison)
    assert same(COMPARISON_JSON.read(path), comparison)


def test_features_without_curves_come_back() -> None:
    alone = features_only()
    assert same(COMPARISON_JSON.from_json(json.loads(json.dumps(COMPARISON_JSON.to_json(alone)))), alone)


def test_verdict_comes_back_from_its_file(comparison: Comparison, tmp_path: Path) -> None:
    verdict = synthetic_verdict(comparison)
    path = tmp_path / "diagnosis.json"
    VERDICT_JSON.write(path, verdict)
    assert same(VERDICT_JSON.read(path), verdict)


def test_diagnosis_has_the_keys_that_others_read(comparison: Comparison) -> None:
    content = VERDICT_JSON.to_json(synthetic_verdict(comparison))
    assert {"verdict", "effects", "group", "candidates", "error", "next_measurement"} <= set(content)
    assert {"before", "after", "held_out_before", "held_out_after", "repeatability"} == set(content["error"])


def test_complex_is_two_lists_and_nan_is_null(comparison: Comparison) -> None:
    content = COMPARISON_JSON.to_json(comparison)
    measured = comparison.curves[1].measured[0].receptance
    assert content["curves"][1]["measured"][0]["receptance"] == {
        "re": measured.real.tolist(), "im": measured.imag.tolist(),
    }  # fmt: skip
    assert content["curves"][0]["frac"] is None
    json.dumps(content, allow_nan=False)


def change(content: dict[str, Any], path: tuple[Any, ...], value: Any) -> dict[str, Any]:
    place: Any = content
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    return content


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("schema",), "updamp comparison 9", "schema is 'updamp comparison 9'.*updamp compare"),
        (("adequate",), 1, r"comparison\.adequate: bool needed, found 1"),
        (("values",), 3.5, r"comparison\.values: int needed, found 3\.5"),
        (("values",), True, r"comparison\.values: int needed, found True"),
        (("title",), None, r"comparison\.title: str needed, found None"),
        (("chi2_after",), "large", r"comparison\.chi2_after: a number is needed, found 'large'"),
        (("findings",), {}, r"comparison\.findings: a list is needed, found dict"),
        (("scatter",), [], r"comparison\.scatter: a table is needed, found list"),
        (("extra",), 1, "comparison: unknown 'extra'"),
        (("curves", 1, "after", "visited", 0), 0.5, r"curves\[1\]\.after\.visited: entries are not all bool"),
        (("curves", 1, "after", "receptance"), [1.0], r"after\.receptance: lists 're' and 'im' are needed"),
        (("curves", 1, "after", "receptance", "re"), [1.0], r"'re' has shape \(1,\), 'im' \(200,\)"),
        (("curves", 1, "band", 0), [1.0], r"curves\[1\]\.band: no array of float64"),
        (("contact_states", "IP 0.96 N"), [1.0], r"contact_states\.IP 0\.96 N: 4 entries needed, found 1"),
    ],
)
def test_content_that_does_not_fit_is_refused_by_name(
    comparison: Comparison, path: tuple[Any, ...], value: Any, message: str
) -> None:
    content = json.loads(json.dumps(COMPARISON_JSON.to_json(comparison)))
    with pytest.raises(ValueError, match=message):
        COMPARISON_JSON.from_json(change(content, path, value))


def test_missing_field_is_named(comparison: Comparison) -> None:
    content = COMPARISON_JSON.to_json(comparison)
    del content["curves"][0]["band"]
    with pytest.raises(ValueError, match=r"comparison\.curves\[0\]: no 'band'"):
        COMPARISON_JSON.from_json(content)


@pytest.mark.parametrize("text", ["", "[1, 2", '"words"', "[]", "\x00\x01"])
def test_file_that_is_no_comparison_is_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "broken.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"broken\.json"):
        COMPARISON_JSON.read(path)


def test_unknown_verdict_is_refused(comparison: Comparison) -> None:
    content = VERDICT_JSON.to_json(synthetic_verdict(comparison))
    with pytest.raises(ValueError, match=r"verdict\.verdict: 'guessed' is none of adequate"):
        VERDICT_JSON.from_json(change(content, ("verdict",), "guessed"))


@dataclass(frozen=True)
class Sometimes:
    level: float | None


def test_none_and_nan_are_not_confused() -> None:
    assert decode(Sometimes, encode(Sometimes(None))) == Sometimes(None)
    assert decode(Sometimes, encode(Sometimes(0.1 + 0.2))) == Sometimes(0.1 + 0.2)
    with pytest.raises(ValueError, match=r"Sometimes\.level is nan; None"):
        encode(Sometimes(math.nan))


def test_type_without_a_rule_is_refused() -> None:
    with pytest.raises(TypeError, match="no JSON form for set"):
        encode({"a": {1, 2}})
