"""What is said of a model without contacts that fails: what was not read is told too."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
from support.held_beam import MODE, RIG, held_beam, of_beam

from updamp.comparison.findings.direction import Misfit
from updamp.comparison.findings.findings import findings
from updamp.comparison.findings.gross_misfit import gross_misfits
from updamp.comparison.findings.kinds import Damping, Frequency
from updamp.comparison.findings.words import aimed_at
from updamp.comparison.fit.observations import plan_of
from updamp.comparison.fit.scatter import Scatter
from updamp.model.calibration import LOSS_FACTOR

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


def test_what_levels_differ_by_is_held_against_what_assemblies_differ_by_in_all_of_them_alike() -> None:
    """Resonances fall by 0.04 % from level to level, those of the second assembly lie 0.25 % lower. Without the fall
    nothing stands out, and where the model is off in all levels alike neither does."""
    tests, repeats = range(3), (1, 2)
    plan = SimpleNamespace(
        conditions=[SimpleNamespace(mode="first") for _ in tests],
        observations=[SimpleNamespace(test=t, repeat=r) for r in repeats for t in tests],
    )
    scatter = Scatter({LOSS_FACTOR.name: 0.01}, drift=5e-5)
    fit = SimpleNamespace(compared=SimpleNamespace(scatter=scatter))
    falls, assemblies = np.array([4e-4, 0.0, -4e-4]), np.array([1.25e-3, -1.25e-3])

    def significance(fall: float, off: float) -> list[float]:
        logs = (assemblies[:, None] + fall * falls).ravel()
        measured = SimpleNamespace(mode="first", frequency=80 * np.exp(logs), damping=np.full(6, 0.01))
        model = SimpleNamespace(mode="first", frequency=np.full(3, 80 * np.exp(off)), damping=np.full(3, 0.01))
        found = gross_misfits(fit, plan, [measured, measured], [model, model])
        return [m.significance for m in found if isinstance(m.direction, Frequency)]

    low, right, high = significance(1.0, 0.0)
    assert low < -7
    assert high > 7
    assert abs(right) < 1e-6
    for fall, off in ((0.0, 0.0), (0.0, 1e-3), (0.1, 0.0)):
        assert max(np.abs(significance(fall, off))) < 2


def test_levels_are_called_what_they_were_aimed_at() -> None:
    assert aimed_at(SimpleNamespace(level=0.2005, level_name="0.2005 N")) == "0.2 N"
    assert aimed_at(SimpleNamespace(level=0.213, level_name="0.213 N")) == "0.213 N"
