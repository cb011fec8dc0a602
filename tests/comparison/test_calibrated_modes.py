"""Of several modes, the factor on all and the one on each together are told far better than each of the two."""

from dataclasses import replace

import pytest
from support.two_modes import swept_arm, two_modes

from updamp.comparison.compare import compare
from updamp.comparison.comparison import COMPARISON_JSON


def test_a_mode_measured_higher_has_its_stiffness_told(tmp_path) -> None:
    """The first mode half a per cent higher than the rig file says, the second where it says."""
    measurement = swept_arm(modes=("first", "second"))
    first, second = measurement.runs
    higher = replace(first, frequency=1.005 * first.frequency, response=first.response / 1.005**2)
    comparison, _ = compare(two_modes(), replace(measurement, runs=(higher, second)))
    together = {each.name: each for each in comparison.calibrated_modes}
    for mode, factor in (("first", 1.005**2), ("second", 1.0)):
        found = together[f"modal stiffness of the mode '{mode}'"]
        assert found.after == pytest.approx(factor, rel=1e-3)
        assert found.lower <= factor <= found.upper
    alone = {each.name: each for each in comparison.calibration}
    width = alone["modal_stiffness"].upper - alone["modal_stiffness"].lower
    assert found.upper - found.lower < 0.2 * width
    COMPARISON_JSON.write(tmp_path / "comparison.json", comparison)
    again = COMPARISON_JSON.read(tmp_path / "comparison.json")
    assert again.calibrated_modes == comparison.calibrated_modes
    one = compare(two_modes(), replace(swept_arm(), runs=(first,)))[0]
    assert one.calibrated_modes, "of the mode that was not measured what is known beforehand"
