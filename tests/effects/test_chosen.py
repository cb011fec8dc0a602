"""Effects in a rig file, and a user's own: read, or refused with what to do."""

import pickle
import subprocess
import sys
import textwrap
import tomllib
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from updamp.effects import catalogue as module
from updamp.effects.catalogue import CATALOGUE, FAULTS, JOINTS, catalogue
from updamp.effects.chosen import chosen_effects, with_effects
from updamp.effects.user_effect import EffectError, effect_from_file
from updamp.rig.errors import RigError

OWN = """
from updamp.effects.effect import Effect, EffectParameter

def apply(model, values):
    return model.with_contacts(mu=model.contacts.parameters.mu * values["factor"])

EFFECT = Effect("oily", "someone oiled it", (EffectParameter("factor", 1.0, 0.01, 1.0, 0.3, "", "a guess"),), apply)
"""


def read(text: str, folder: Path = Path()):
    return chosen_effects(tomllib.loads(text)["effects"], folder)


@pytest.fixture
def own(tmp_path) -> Path:
    path = tmp_path / "oily.py"
    path.write_text(OWN)
    return path


def test_effects_are_read_with_units_and_applied_in_the_file_s_order(model, own):
    chosen = read(
        """
        [[effects]]
        name = "edge_gap"
        values = { depth = "0.3 um" }
        origin = "fitted to campaign 3"
        [[effects]]
        name = "oily"
        file = "oily.py"
        values = { factor = 0.5 }
        [[effects]]
        name = "shaker_attachment"
        values = { mass = "20 g" }
        """,
        own.parent,
    )
    assert [c.effect.name for c in chosen] == ["edge_gap", "oily", "shaker_attachment"]
    assert chosen[0].values["depth"] == pytest.approx(3e-7)
    assert chosen[0].origin == "fitted to campaign 3"
    assert chosen[1].file == own
    assert dict(chosen[2].values) == {"mass": 0.02, "stiffness": 0.0, "dashpot": 0.0}
    changed = with_effects(model, chosen)
    np.testing.assert_allclose(changed.contacts.parameters.mu, 0.5 * np.asarray(model.contacts.parameters.mu))
    assert changed.attachments[-1].mass == 0.02
    assert with_effects(model, ()) is model


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('name = "edge_gab"\nvalues = {}', 'effects[0].name = "edge_gab": no such effect; did you mean edge_gap?'),
        ('values = { depth = "1 um" }', "effects[0].name: missing"),
        ('name = "edge_gap"', 'effects[0].values: missing; add it, such as values = { depth = "3e-07 m" }'),
        ('name = "edge_gap"\nvalues = { depth = 1e-7 }', "effects[0].values.depth = 1e-07: state its unit as text"),
        ('name = "edge_gap"\nvalues = { depth = "1 s" }', "wrong dimension"),
        ('name = "edge_gap"\nvalues = { depth = "1 mm" }', "out of range: allowed is 0 to 5e-06 m"),
        ('name = "joint_quadratic"\nvalues = { coefficient = "-1 N*s^2/m^2" }', "any value from 0 on, in N*s"),
        ('name = "joint_viscoelastic"\nvalues = { relaxation_time = "0 s" }', "allowed is any positive value, in s"),
        ('name = "edge_gap"\nvalues = { dept = "1 um" }', "values.dept: unknown parameter; did you mean depth?"),
        ('name = "pressure_crown"\nvalues = { crown = "1 m" }', "a number is wanted, such as 0.8"),
        ('name = "edge_gap"\nvalues = {}\nvalue = 1', "effects[0].value: unknown key; did you mean values?"),
        ('name = "edge_gap"\nvalues = {}\norigin = 3', "effects[0].origin = 3: text is wanted"),
        ('name = "edge_gap"\nvalues = {}\nfile = "no.py"', "no.py: no such file; give a Python file"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_what_would_be_right(text, says):
    with pytest.raises(RigError) as error:
        read(f"[[effects]]\n{text}")
    assert says in str(error.value)


def test_what_grows_with_the_rig_may_have_any_size():
    """Bounds are those of a beam of 5e5 N/m; a wire of 3.5e-3 N/m has a background of 2.8e4 m/N."""
    text = 'name = "feed_through"\nvalues = { in_phase = "28239 m/N", in_quadrature = "-12710 m/N" }'
    (found,) = read(f"[[effects]]\n{text}")
    assert dict(found.values) == {"in_phase": 28239.0, "in_quadrature": -12710.0}


def test_all_problems_are_told_at_once():
    with pytest.raises(RigError) as error:
        read('[[effects]]\nname = "edge_gab"\n[[effects]]\nname = "pressure_crown"\nvalues = { crown = 9, d = 1 }')
    assert len(str(error.value).splitlines()) == 3


def test_an_effect_is_taken_up_once():
    with pytest.raises(RigError, match='"wire_stiffness" is there 2 times'):
        read('[[effects]]\nname = "wire_stiffness"\nvalues = { factor = 2 }\n' * 2)


@pytest.mark.parametrize("tables", [{"name": "edge_gap"}, "edge_gap", [1]])
def test_other_than_an_array_of_tables_is_refused(tables):
    with pytest.raises(RigError, match="an array of tables is wanted"):
        chosen_effects(tables, Path())


@pytest.mark.parametrize(
    ("code", "says"),
    [
        ("x = 1", "defines no EFFECT"),
        ("EFFECT = 3", "EFFECT is a int"),
        ("raise OSError('no disk')", "cannot be run: OSError: no disk"),
        (OWN.replace("0.3, \"\"", "3.0, \"\""), "typical = 3 has to lie within the bounds"),
        (OWN.replace("\"factor\", 1.0", "\"factor\", 2.0"), "null = 2 has to lie within"),
    ],
)  # fmt: skip
def test_a_file_without_a_usable_effect_is_refused(tmp_path, code, says):
    path = tmp_path / "mine.py"
    path.write_text(code)
    with pytest.raises(EffectError, match=says):
        effect_from_file(path)


def test_name_in_the_rig_file_is_that_of_the_user_s_effect(own):
    with pytest.raises(RigError, match='defines "oily"; state that name'):
        read('[[effects]]\nname = "dry"\nfile = "oily.py"\nvalues = {}', own.parent)


def test_a_user_s_effect_goes_to_another_process_that_has_read_the_file(own, tmp_path):
    (tmp_path / "effect.pickle").write_bytes(pickle.dumps(effect_from_file(own)))
    code = textwrap.dedent(f"""
        import pickle
        from pathlib import Path
        from updamp.effects.user_effect import effect_from_file
        own = effect_from_file(Path({str(own)!r}))
        assert pickle.loads(Path({str(tmp_path / "effect.pickle")!r}).read_bytes()) == own
    """)
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_user_s_effect_of_a_rig_file_goes_to_a_process_that_was_started_elsewhere(own, tmp_path, monkeypatch):
    monkeypatch.chdir(own.parent)
    sent = pickle.dumps(read('[[effects]]\nname = "oily"\nfile = "oily.py"\nvalues = { factor = 0.5 }'))
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    (found,) = pickle.loads(sent)
    assert (found.effect.name, found.values, found.file) == ("oily", {"factor": 0.5}, own.resolve())


class Installed(EntryPoint):
    def load(self):
        return replace(CATALOGUE["edge_gap"], name=self.name) if self.value == "good" else 1 / 0


def test_installed_packages_add_effects(monkeypatch):
    def offer(name, value):
        monkeypatch.setattr(module, "entry_points", lambda group: [Installed(name, value, group)])

    offer("rounded", "good")
    assert [*catalogue()] == [*CATALOGUE, *JOINTS, *FAULTS, "rounded"]
    offer("edge_gap", "good")
    with pytest.raises(EffectError, match='there is an effect "edge_gap" already; rename it'):
        catalogue()
    offer("broken", "bad")
    with pytest.raises(EffectError, match=r'"broken" \(bad\).*cannot be loaded: division by zero'):
        catalogue()
