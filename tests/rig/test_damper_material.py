"""[damper.material] in a rig file: what is read, refused and asked, and which keys it enters."""

import io
import re
from pathlib import Path

import pytest
from pydantic_core import to_json
from rich.console import Console

from updamp.model.rig_files import load_rig
from updamp.rig.damper_mass import damper_mass
from updamp.rig.errors import RigError
from updamp.rig.questions import questions
from updamp.rig.rig import Rig
from updamp.rig.tables import derived_table, values_table

RIG = Path(__file__).parents[1] / "data" / "short_faces.toml"
TITANIUM = {"youngs_modulus": "114 GPa", "poissons_ratio": 0.33, "density": "4430 kg/m^3", "loss_factor": 0.0005}


def rig_with(**stated: object) -> Rig:
    return load_rig(RIG, {"damper.material": TITANIUM | stated})


def problems(material: dict[str, object]) -> list[str]:
    with pytest.raises(RigError) as refused:
        load_rig(RIG, {"damper.material": material})
    return str(refused.value).splitlines()[1:]


def printed(table: object) -> str:
    """Without lines, with one blank between the cells."""
    console = Console(file=io.StringIO(), width=120)
    console.print(table)
    return " ".join(re.sub("[^ -~]", " ", console.file.getvalue()).split())  # type: ignore[attr-defined]


def test_left_out_it_is_that_of_the_blades() -> None:
    plain, own = load_rig(RIG), rig_with()
    assert plain.damper.material is None
    assert plain.damper_material == plain.material
    assert own.damper_material.density == 4430
    assert own.material == plain.material
    assert own.loss_factors == {"blade_left": 0.00095, "blade_right": 0.00095, "damper": 0.0005}
    assert damper_mass(own) == pytest.approx(damper_mass(plain) * 4430 / 7800)


def test_an_unknown_key_a_missing_one_and_a_wrong_value_are_refused_by_their_own_names() -> None:
    (unknown,) = problems(TITANIUM | {"densty": "4430 kg/m^3"})
    assert unknown == 'damper.material.densty = "4430 kg/m^3": unknown key; did you mean density?'
    missing = problems({"density": "4430 kg/m^3"})
    assert len(missing) == 3
    assert missing[0] == 'damper.material.youngs_modulus: missing; add it, such as youngs_modulus = "197 GPa"'
    (bare,) = problems(TITANIUM | {"density": 4430})
    assert bare == 'damper.material.density = 4430: state its unit as text, such as "7800 kg/m^3"'
    (ratio,) = problems(TITANIUM | {"poissons_ratio": 0.6})
    assert ratio.startswith("damper.material.poissons_ratio = 0.6: ")
    with pytest.raises(
        RigError, match=r'damper\.material = "titanium": a table of keys is wanted, \[damper\.material\]'
    ):
        load_rig(RIG, {"damper.material": "titanium"})


def test_an_odd_value_is_asked_about_by_its_own_name() -> None:
    odd = {"density": "44.3 kg/m^3", "youngs_modulus": "114 MPa", "loss_factor": 0.5}
    asked = questions(rig_with(**odd))
    assert [question.split(" = ")[0] for question in asked] == [
        "damper.material.youngs_modulus", "damper.material.density", "damper.material.loss_factor",
    ]  # fmt: skip
    assert questions(rig_with()) == questions(load_rig(RIG)) == []
    (of_both,) = [line for line in questions(load_rig(RIG, {"material.density": "44 kg/m^3"})) if "density" in line]
    assert of_both.startswith("material.density = 44 kg/m^3")


def test_what_was_stored_before_the_table_existed_still_holds() -> None:
    plain, own, lossy = load_rig(RIG), rig_with(), rig_with(loss_factor=0.001)
    assert b'"material"' not in to_json(plain.damper)
    assert b'"material"' in to_json(own.damper)
    assert len({one.state for one in (plain, own, lossy)}) == 3
    assert plain.digest("damper") == own.digest("damper"), "of the dimensions alone"
    assert plain.digest("damper").startswith("cccfeac8020c0ae5"), "as the version before had it"
    assert own.digest("damper.material.density") != plain.digest("damper.material.density")
    assert own.digest("damper.material.density") == lossy.digest("damper.material.density")


def test_whether_it_is_stated() -> None:
    plain, cork = load_rig(RIG), rig_with(poissons_ratio=0.0)
    assert not plain.states("damper.material")
    assert not plain.states("damper.material.poissons_ratio")
    assert cork.states("damper.material.poissons_ratio"), "0 is a value"


def test_check_states_the_dampers_mass_and_its_material() -> None:
    plain, own = load_rig(RIG), rig_with()
    for rig in (plain, own):
        assert f"damper's mass {1e3 * damper_mass(rig):.2f} g" in printed(derived_table(rig))
    assert "damper.material.density 4430 kg/m^3" in printed(values_table(own))
    assert "damper.material not stated" in printed(values_table(plain))
