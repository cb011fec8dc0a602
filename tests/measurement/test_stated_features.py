"""Values and bounds that a paper states."""

import math
from pathlib import Path

import numpy as np
import pytest
from support.measured_oscillator import TOML, recorded

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import MeasurementError
from updamp.measurement.readers.long_csv import write_long_csv

PAPER = Path(__file__).parents[2] / "rigs" / "pesaresi2017_measured.toml"


def test_the_papers_five() -> None:
    measurement = load_measurement(PAPER, ["blade_right.excitation.x"])
    assert measurement.runs == ()
    assert (measurement.pull, measurement.excitation) == (960.0, "blade_right.excitation.x")
    rows = [(f.quantity, f.mode, f.force, f.value, f.lower, f.upper) for f in measurement.features]
    wanted = [
        ("resonance_frequency", "1F without damper", math.nan, 269.0, math.nan, math.nan),
        ("resonance_frequency", "OOP", 0.096, 435.9, math.nan, math.nan),
        ("resonance_frequency", "IP", 0.096, 393.0, math.nan, math.nan),
        ("resonance_frequency_shift", "OOP", 17.0, math.nan, math.nan, 0.01),
        ("resonance_frequency", "IP", 17.0, math.nan, 360.0, 385.0),
    ]
    assert [row[:2] for row in rows] == [row[:2] for row in wanted]
    np.testing.assert_array_equal([row[2:] for row in rows], [row[2:] for row in wanted])
    assert measurement.features[1].relative_uncertainty == 0.0005
    assert measurement.hashes is not None
    assert list(measurement.hashes) == ["pesaresi2017_measured.toml"]


def test_copy_states_what_the_reference_states(shared_reference: Path) -> None:
    reference = load_measurement(shared_reference / "pesaresi2017_measured.toml")
    assert repr(reference.features) == repr(load_measurement(PAPER).features)
    assert math.isnan(reference.pull)
    assert any("damper_load is not stated" in text for text in reference.assumptions)


def test_features_beside_curves(tmp_path: Path) -> None:
    write_long_csv(tmp_path / "data.csv", [recorded()])
    (tmp_path / "stated.toml").write_text(PAPER.read_text())
    path = tmp_path / "measurement.toml"
    path.write_text('features = "stated.toml"\n' + TOML)
    measurement = load_measurement(path)
    assert len(measurement.features) == 5
    assert measurement.hashes is not None
    assert set(measurement.hashes) == {"measurement.toml", "data.csv", "stated.toml"}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"435.9 Hz"', '"435.9 mm"', ["feature[1].value", "435.9 mm", "wrong dimension"]),
        ('"435.9 Hz"', "435.9", ["feature[1].value", "state its unit"]),
        ("upper_bound = 0.01", 'upper_bound = "1 Hz"', ["feature[3].upper_bound", "a plain number"]),
        ('lower_bound = "360 Hz"', 'lower_bound = "390 Hz"', ["feature[4].lower_bound", "below upper_bound"]),
        (
            'quantity = "resonance_frequency_shift"',
            'quantity = "shift"',
            ["feature[3].quantity", "shift", "allowed are"],
        ),
        ("relative_uncertainty = 0.002\n", "", ["feature[0].relative_uncertainty: missing"]),
        ('value = "269 Hz"', 'vlaue = "269 Hz"', ["feature[0].vlaue", "did you mean value"]),
    ],
)
def test_refusals(tmp_path: Path, old: str, new: str, words: list[str]) -> None:
    text = PAPER.read_text()
    assert old in text
    path = tmp_path / "stated.toml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(MeasurementError) as error:
        load_measurement(path)
    for word in ("stated.toml", *words):
        assert word in str(error.value)
