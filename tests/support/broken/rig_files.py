"""Broken rig files: one place of a sound file changed, or its bytes."""

from collections.abc import Callable
from io import StringIO
from pathlib import Path

from rich.console import Console
from support.broken.outcome import Broken, Told, call, command

from updamp.model.rig_files import load_rig
from updamp.workflow.progress import Display
from updamp.workflow.run import Run
from updamp.workflow.run_options import RunOptions

RIGS = Path(__file__).parents[3] / "rigs"
REFERENCE = (RIGS / "pesaresi2017.toml").read_text(encoding="utf-8")
MODAL = (RIGS / "brake_reuss.toml").read_text(encoding="utf-8")


def check(path: Path) -> Told:
    return command("check", path)


def begin(path: Path) -> Told:
    """All that `updamp run` does before the work begins: nothing is meshed, nothing allocated."""

    def work() -> str:
        said = StringIO()
        Run(load_rig(path), RunOptions("small", path.parent / "out"), Display(Console(file=said, width=10_000)))
        return said.getvalue()

    return call(work)


def changed(
    old: str, new: str, *words: str, text: str = REFERENCE, give: Callable[[Path], Told] = check, name: str = ""
) -> Broken:
    """One place of the text; the first words are those of the name."""
    assert old in text, old

    def made(folder: Path) -> Told:
        path = folder / "mine.toml"
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        return give(path)

    return Broken(f"rig: {name or new.strip() or 'without ' + old.strip()}"[:70].replace("\n", " "), words, made)


def contents(name: str, content: bytes, *words: str, welcome: bool = False) -> Broken:
    def made(folder: Path) -> Told:
        path = folder / "mine.toml"
        path.write_bytes(content)
        return check(path)

    return Broken(f"rig: {name}", words, made, welcome)


def _folder(folder: Path) -> Told:
    return check(folder)


def _missing(folder: Path) -> Told:
    return check(folder / "mine.toml")


SOUND = REFERENCE.encode()
FILES = [
    Broken("rig: no such file", ("mine.toml", "no such file"), _missing),
    Broken("rig: a folder", ("a folder", "rig file"), _folder),
    contents("empty", b"", "mine.toml", "empty", "rigs/pesaresi2017.toml"),
    contents("comments alone", b"# nothing\n\n", "mine.toml", "empty", "rigs/pesaresi2017.toml"),
    contents("BOM", b"\xef\xbb\xbf" + SOUND, "pesaresi2017", welcome=True),
    contents("UTF-16", REFERENCE.encode("utf-16"), "mine.toml", "UTF-16", "save it as UTF-8"),
    contents("Latin-1", b"# K\xf6ln\n" + SOUND, "mine.toml", "line 1", "save it as UTF-8"),
    contents("zip", b"PK\x03\x04" + bytes(range(256)), "mine.toml", "no text"),
    contents("zeros", bytes(1000), "mine.toml", "no text"),
    contents("cut off", SOUND[: SOUND.index(b"GPa")], "mine.toml", "not valid TOML", "line"),
    contents("cut off between tables", SOUND[: SOUND.index(b"[contact]")], "mine.toml", "contact: missing"),
    contents("Windows line ends", REFERENCE.replace("\n", "\r\n").encode(), "pesaresi2017", welcome=True),
    contents("JSON", b'{"name": "rig"}', "mine.toml", "not valid TOML", "line 1"),
    contents("CSV", b"a,b,c\n1,2,3\n", "mine.toml", "not valid TOML", "line 1"),
    contents("a measurement", (RIGS / "brake_reuss_measurement.toml").read_bytes(), "mine.toml", "measurement"),
    contents("a study", (RIGS / "studies" / "friction.toml").read_bytes(), "mine.toml", "study"),
]

HEIGHT, THICK = 'height = "150 mm"', 'thickness = "7 mm"'
SYNTAX = [
    changed(HEIGHT, f"{HEIGHT}\n{HEIGHT}", "mine.toml", "height", "twice", "line", name="a key twice"),
    changed("[blade]", "[wire]\n[blade]", "mine.toml", "wire", "twice", "line", name="a table twice"),
    changed(HEIGHT, 'height = "150 mm', "mine.toml", "line", '"150 mm', "quote"),
    changed(HEIGHT, 'height = "150 mm";', "mine.toml", "line", "semicolon"),
    changed(HEIGHT, "height = 150,5", "mine.toml", "line", "decimal point"),
    changed(HEIGHT, 'height = "150,5 mm"', "blade.height", "150,5 mm", "decimal point"),
    changed(HEIGHT, "height = 150 mm", "mine.toml", "line", "150 mm", "quotes"),
    changed(HEIGHT, "height: 150", "mine.toml", "line", "height: 150", "="),
    changed("[blade]", "[blade", "mine.toml", "line", "[blade"),
]

VALUES = [
    changed(HEIGHT, 'height = "150"', "blade.height", "150", "state its unit", "150 mm"),
    changed(HEIGHT, "height = 150", "blade.height", "150", "unit", "150 mm"),
    changed(HEIGHT, 'height = "150 mmm"', "blade.height", "unknown unit", "mmm"),
    changed(HEIGHT, 'height = "150 kg"', "blade.height", "wrong dimension", "150 mm"),
    changed(HEIGHT, 'height = "nan mm"', "blade.height", "finite"),
    changed(HEIGHT, 'height = "inf mm"', "blade.height", "finite"),
    changed(HEIGHT, "height = true", "blade.height", "true", "150 mm"),
    changed(HEIGHT, "height = []", "blade.height", "[]", "150 mm"),
    changed(HEIGHT, 'height = "1e9999999999 mm"', "blade.height", "finite"),
    changed(HEIGHT, 'height = "150 km"', "blade.height", "out of range"),
    changed(THICK, 'thickness = "-7 mm"', "blade.thickness", "-7 mm", "out of range"),
    changed(THICK, 'thickness = "0 mm"', "blade.thickness", "0 mm", "out of range"),
    changed(THICK, 'thickness = "1e-12 mm"', "blade.thickness", "1e-12 mm", "out of range", "at least"),
    changed(THICK, 'thickness = "0.002 mm"', "blade.thickness", "0.002 mm", "thin", "?"),
    changed('width = "25 mm"', 'width = "1e9 mm"', "blade.width", "1e9 mm", "out of range", "at most"),
    changed('width = "25 mm"', 'width = "9 m"', "blade.width", "wide", "?"),
    changed('"960 N"', '"1e300 N"', "load.pull", "1e300 N", "out of range", "at most"),
    changed('"960 N"', '"-960 N"', "load.pull", "-960 N", "out of range"),
    changed('"960 N"', '"960 kg"', "load.pull", "wrong dimension"),
    changed('"197 GPa"', '"197 MPa"', "material.youngs_modulus", "197 MPa", "GPa", "?"),
    changed('"197 GPa"', '"197 TPa"', "material.youngs_modulus", "out of range"),
    changed('"7800 kg/m^3"', '"7.8 kg/m^3"', "material.density", "7.8 kg/m^3", "?"),
    changed("poissons_ratio = 0.3", "poissons_ratio = 0.5", "material.poissons_ratio", "0.5", "0.49"),
    changed("poissons_ratio = 0.3", "poissons_ratio = 3", "material.poissons_ratio", "3", "0.49"),
    changed("loss_factor = 0.0006", "loss_factor = 9", "material.loss_factor", "9", "less than 1"),
    changed("loss_factor = 0.0006", "loss_factor = 0.9", "material.loss_factor", "0.9", "?"),
    changed("loss_factor = 0.0006", "loss_factor = 0.0", "material.loss_factor = 0.0", "no bound", "0.0001"),
    changed("loss_factor = 0.0006", "loss_factor = 1e-12", "material.loss_factor", "1e-12", "0.0001", "?"),
    changed("friction_coefficient = 0.6", "friction_coefficient = 60", "friction_coefficient", "60"),
    changed("friction_coefficient = 0.6", "friction_coefficient = -0.6", "friction_coefficient", "-0.6"),
    changed("friction_coefficient = 0.6", 'friction_coefficient = "0.6"', "friction_coefficient", "0.6", "number"),
    changed('_stiffness = "60000 N/mm^3"', '_stiffness = "1e300 N/mm^3"', "contact.", "1e300", "not a finite number"),
    changed('_stiffness = "60000 N/mm^3"', '_stiffness = "60000 N/m^3"', "contact.", "60000 N/m^3", "N/mm^3", "?"),
    changed('"1e6 N/m"', '"1e300 N/m"', "wire.axial_stiffness", "1e300", "out of range", "at most"),
    changed('"17 N"]', '"17 MN"]', "study.force_levels", "17 MN", "960 N", "?"),
    changed('"17 N"]', '"9.6 N"]', "study.force_levels", "once"),
    changed('["0.096 N", "0.96 N", "3.84 N", "9.6 N", "17 N"]', "[]", "study.force_levels", name="no force levels"),
    changed('["433 Hz", "451 Hz"]', '["451 Hz", "433 Hz"]', "study.modes.OOP.window", "lower", "first"),
    changed('["433 Hz", "451 Hz"]', '["433 Hz", "433 Hz"]', "study.modes.OOP.window", "below"),
    changed('["433 Hz", "451 Hz"]', '["433 Hz"]', "study.modes.OOP.window[1]", "missing"),
    changed('["433 Hz", "451 Hz"]', '["433 kHz", "451 kHz"]', "study.modes.OOP.window", "433 kHz", "Hz", "?"),
    changed('["433 Hz", "451 Hz"]', '["1 Hz", "2 Hz"]', "study.modes.OOP.window", "1 Hz", "?"),
    changed('["433 Hz", "451 Hz"]', '["433 rad/s", "451 rad/s"]', "study.modes.OOP.window", "Hz"),
    changed('"20 deg"', '"30 %"', "platform.underside_angle", "deg"),
    changed('"20 deg"', '"89 deg"', "platform.underside_angle", "out of range"),
    changed('law = "jenkins_box"', 'law = "jenkins"', "contact.law", "jenkins_box"),
    changed('model = "polynomial"', 'model = "hertz"', "contact.pressure.model", "hertz", "uniform"),
    changed("[1.0, 0.0, -2.6, 0.0, 1.69]", "[-1.0, 0.0]", "contact.pressure"),
    changed('solver = "pardiso"', 'solver = "mumps"', "reduction.solver", "pardiso"),
    changed('name = "pesaresi2017"', 'name = "my rig"', "name", "my rig", "letter"),
]

GEOMETRY = [
    changed('face_length = "4 mm"', 'face_length = "49.5 mm"', "damper.face_length", "49.5 mm", "allowed is less than"),
    changed('face_start = "0.4 mm"', 'face_start = "200 mm"', "damper.face_start", "do not touch"),
    changed('"43.35 mm"', '"433 mm"', "platform.top", "must be below the blade's tip"),
    changed('"43.35 mm"', '"5 mm"', "platform.top", "below the root"),
    changed(
        '"43.35 mm"', '"5 mm"', "platform.top", "allowed is more than 28.932 mm", "room", name="the platform too low"
    ),
    changed('"11.4 mm"', '"103 mm"', "excitation.height", "raise platform.top above", name="the excitation too high"),
    changed('apex_flat = "3 mm"', 'apex_flat = "30 mm"', "damper.apex_flat = 30 mm", "no meaning", "mm wide", "?"),
    changed('"11.4 mm"', '"103 mm"', "excitation.height", "103 mm", "below"),
    changed('"20 mm"', '"140 mm"', "response.below_top", "140 mm"),
    changed('"46 mm"', '"3 mm"', "blade.axis_offset", "3 mm", "more"),
    changed('gap = "2.4 mm"', 'gap = "400 mm"', "blade.axis_offset", "gap"),
]

KEYS = [
    changed("[wire]", "[wires]", "wires", "did you mean wire"),
    changed("axial_stiffness", "axial_stifness", "wire.axial_stifness", "did you mean axial_stiffness"),
    changed('axial_stiffness = "1e6 N/m"', "", "wire.axial_stiffness", "missing", "1e6 N/m"),
    changed("[wire]", "[wire]\ncolour = 3", "wire.colour", "unknown key"),
    changed("modes = 24", "modes = 0", "reduction.modes", "0"),
    changed("modes = 24", "modes = 2400", "reduction.modes = 2400", "10 to 50", "GB", "?"),
    changed("modes = 24", "modes = 24.5", "reduction.modes", "24.5"),
    changed("width = 12", "width = 11", "mesh.small.width", "11", "multiple of 2"),
    changed("face = 4", "face = 0", "mesh.small.face", "0"),
    changed("contact_elements = 72", "contact_elements = 71", "contact_elements", "71", "multiple of 2"),
    changed("contact_elements = 72", "contact_elements = 72\ncontact_strips = 0", "mesh.small.contact_strips", "0"),
    changed("contact_elements = 72", "contact_elements = 72\ncontact_strips = 20", "contact_strips = 20", "at most 18"),
    changed("[0, 1, 2, 3] ", "[0, 2, 3] ", "harmonics", "must contain 1"),
    changed("[0, 1, 2, 3] ", "[0, 1, 1] ", "harmonics", "once"),
    changed("[0, 1, 2, 3] ", "[] ", "harmonics", "must contain 1"),
    changed("[0, 1, 2, 3] ", '"all" ', "harmonics", "auto"),
    changed("[0, 1, 2, 3] ", "[-1, 1] ", "harmonics", "-1"),
    changed("time_samples = 128", "time_samples = 6", "time_samples", "6", "above"),
    changed("cycles = 2", "cycles = 1", "cycles", "1"),
]

# What the machine's memory does not hold is refused before anything is allocated, with what would fit.
FITS = ("memory", "GB", "at most")
MEMORY = [
    changed("face = 4", "face = 4000000", "mesh.small", *FITS, give=begin),
    changed("stem_above_platform = 12", "stem_above_platform = 9999999999", "mesh.small", *FITS, give=begin),
    changed("width = 12", "width = 400000", "mesh.small", *FITS, give=begin),
    changed("contact_elements = 72", "contact_elements = 720000000", "contact_elements", *FITS, give=begin),
    changed("time_samples = 128", "time_samples = 1000000000000", "time_samples", *FITS, give=begin),
    changed("cycles = 2", "cycles = 2000000000", "cycles", *FITS, give=begin),
    changed("[0, 1, 2, 3] ", "[0, 1, 40000000] ", "harmonic", *FITS, text=REFERENCE.replace(
        "time_samples = 128", "time_samples = 90000000"), give=begin),
    changed("modes = 24", "modes = 24000000", "reduction.modes", "24000000", "at most", give=begin),
]  # fmt: skip

EFFECT = '\n[[effects]]\nname = "{}"\nvalues = {{ {} }}\n'
END = "[mesh.small]"


def effect(name: str, values: str, *words: str, more: str = "") -> Broken:
    return changed(END, f"{EFFECT.format(name, values)}{more}\n{END}", *words, name=f"effect {name} {values} {more}")


EFFECTS = [
    effect("edge_gapp", 'depth = "0.3 um"', "effects[0].name", "edge_gapp", "did you mean edge_gap"),
    effect("edge_gap", 'depth = "0.3 kg"', "effects[0].values.depth", "0.3 kg"),
    effect("edge_gap", "depth = 3e-7", "effects[0].values.depth", "unit"),
    effect("edge_gap", 'width = "1 mm"', "effects[0].values.width", "unknown parameter"),
    effect("edge_gap", 'depth = "3 m"', "effects[0].values.depth", "out of range"),
    effect("mine", "a = 1", "effects[0].file", "mine.py", "no such file", more='file = "mine.py"'),
    changed(END, f"[calibration]\nfriktion = 1.1\n\n{END}", "calibration", "friktion", name="factor unknown"),
]

MODAL_RIG = [
    changed('"80.38 Hz"', '"80.38"', "modes.first_bending.frequency", "unit", text=MODAL),
    changed('"beam.drive.x" = 1.0', '"beam.tip.x" = 1.0', "excitation", "no mode has a shape there", text=MODAL),
    changed("loss_factor = 0.0031", "", "loss_factor", "damping_ratio", "state one of them", text=MODAL),
    changed('modal_mass = "2.0 kg"', 'modal_mass = "-2.0 kg"', "modal_mass", "out of range", text=MODAL),
    changed('modal_mass = "2.0 kg"', "", "shape", "modal_mass", "unit", text=MODAL),
    changed('"modal"', '"modale"', "kind", "modale", "modal", text=MODAL),
]

RIG_FILES = [*FILES, *SYNTAX, *VALUES, *GEOMETRY, *KEYS, *MEMORY, *EFFECTS, *MODAL_RIG]
