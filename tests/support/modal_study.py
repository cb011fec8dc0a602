"""A study on a rig given by modes: no finite elements, a design takes milliseconds."""

from pathlib import Path

RIG = """
kind = "modal"
name = "beam"
excitation = "beam.drive.x"

[modes.first]
frequency = "80 Hz"
loss_factor = 0.003
modal_mass = "2.0 kg"
shape = { "beam.drive.x" = 1.0 }
"""

# An effect of one's own that only takes time.
SLOW = """
import time
from updamp.effects.effect import Effect, EffectParameter

def apply(model, values):
    time.sleep(values["delay"])
    return model

EFFECT = Effect("slow", "someone is slow", (EffectParameter("delay", 0.0, 0.0, 9.0, 0.3, "s", "a guess"),), apply)
"""

STUDY = """
[study]
rig = "beam.toml"
out = "out"

[[variables]]
name = "frequency"
path = "modes.first.frequency"
lower = "60 Hz"
upper = "100 Hz"

[[variables]]
name = "mass"
path = "modes.first.modal_mass"
lower = "500 g"
upper = "8 kg"
scale = "log"

[[responses]]
name = "free"
kind = "free_frequency"
"""


def modal_folder(path: Path) -> Path:
    """With the rig that the study names."""
    (path / "beam.toml").write_text(RIG)
    return path


def write_study(folder: Path, method: str = 'kind = "grid"', more: str = "", text: str = STUDY) -> Path:
    path = folder / "study.toml"
    path.write_text(f"{text}\n{more}\n[method]\n{method}\n")
    return path
