"""What is said of a model without contacts that fails: what was not read is told too."""

from pathlib import Path

from support.held_beam import MODE, RIG, held_beam, of_beam

from updamp.comparison.findings.direction import Misfit
from updamp.comparison.findings.findings import findings
from updamp.comparison.findings.kinds import Damping
from updamp.comparison.fit.observations import plan_of

SOUND = held_beam((80.40,) * 3, (0.003,) * 3)


def test_levels_that_were_not_read_are_no_part_of_every_level() -> None:
    plan = plan_of(SOUND)
    read = [Misfit(Damping(test), relative, 0.01) for test, relative in ((0, 0.20), (1, 0.21))]
    (alike,) = findings(None, plan, read)
    assert alike.text == f"{MODE}: damping 20 % high at 5 m/s\u00b2, 30 m/s\u00b2, not read at 80 m/s\u00b2"
    read.append(Misfit(Damping(2), 0.20, 0.01))
    (every,) = findings(None, plan, read)
    assert every.text == f"{MODE}: damping 20 % high at every level"
    (worst,) = findings(None, plan, [read[0], Misfit(Damping(2), -0.4, 0.01)])
    assert worst.text.endswith("not read at 30 m/s\u00b2")


def test_an_end_of_the_window_is_no_resonance_of_the_model(tmp_path: Path) -> None:
    """A rig file that is four per cent off, where calibration may move it by one or two, leaves the model's resonance
    beyond what was measured: it was told to be at the window's end."""
    far = tmp_path / "far.toml"
    far.write_text(RIG.read_text().replace('"80.38 Hz"', '"85 Hz"'))
    said = of_beam(SOUND, far)
    assert said.findings[0].text.startswith(f"{MODE}: the model has no peak where it was measured")
    assert not [f for f in said.findings if f.text.startswith((f"{MODE}: resonance", "the curves differ"))]
