"""Units as programs spell them, in rows below the names of columns and in the names, and cells that hold no number."""

from pathlib import Path

import numpy as np
import pytest

from updamp.measurement.measurement import MeasurementError
from updamp.measurement.quantities import label_factor, quantity_of_label, si_factor, unit_and_kind
from updamp.measurement.readers.header import Wanted, header_of
from updamp.measurement.readers.table import Table, read_table
from updamp.measurement.readers.units_row import HERTZ, check_axis, units_of_names
from updamp.measurement.recorded import RecordedChannel
from updamp.measurement.sweep_checks import check_statements


def table(path: Path, lines: str, *numeric: str) -> Table:
    (path / "data.csv").write_text(lines)
    return read_table(path / "data.csv", header_of(path / "data.csv", Wanted(numeric)), numeric)


@pytest.mark.parametrize("label", ["kHz", "KHz", "KHZ", "khz", "Khz"])
def test_kilohertz_are_no_hertz_however_they_are_spelled(label):
    with pytest.raises(MeasurementError, match=f"its row of units says {label}, it is read in Hz"):
        check_axis(Path("data.csv"), {"f": label}, "f", "Hz", HERTZ)


def test_a_kilonewton_is_no_knot():
    assert label_factor("KN", "force") == 1e3
    assert [quantity_of_label(one) for one in ("KN", "kN", "MM/S", "G", "um")] == [
        "force", "force", "velocity", "acceleration", "displacement",
    ]  # fmt: skip


def test_units_at_the_end_of_names():
    names = ["f [kHz]", "force (mN)", "tip [mm]", "phase <deg>", "tip (right)", "blade 2 [left]", "(m)"]
    assert units_of_names(names) == {"f [kHz]": "kHz", "force (mN)": "mN", "tip [mm]": "mm", "phase <deg>": "deg"}
    with pytest.raises(MeasurementError, match=r"its name says kHz, it is read in Hz; .* correct that name"):
        check_axis(Path("data.csv"), units_of_names(names), "f [kHz]", "Hz", HERTZ)


def test_decibels_are_refused():
    channel = RecordedChannel(np.ones((1, 3), complex), (1,), unit="dB")
    with pytest.raises(MeasurementError, match="the file says dB, which is logarithmic"):
        check_statements("run", channel, "displacement", "um")


def test_a_word_behind_a_unit_is_held_against_the_amplitude():
    """Passed over with the unit before it: 1000 and 9.8 times off."""
    labels = ["mm rms", "g pk", "mm/s (RMS)", "um p-p", "m/s RMSE", "rms"]
    kinds = [("mm", "rms"), ("g", "peak"), ("mm/s", "rms"), ("um", "peak_to_peak"), ("m/s RMSE", ""), ("rms", "")]
    assert [unit_and_kind(label) for label in labels] == kinds
    channel = RecordedChannel(np.ones((1, 3), complex), (1,), unit="mm rms")
    assert check_statements("run", channel, "displacement", "mm", amplitude="rms") == []
    with pytest.raises(MeasurementError, match=r'the file says mm rms, measurement\.toml amplitude = "peak"'):
        check_statements("run", channel, "displacement", "mm", amplitude="peak")
    with pytest.raises(MeasurementError, match=r'the file says mm rms, measurement\.toml unit = "um"'):
        check_statements("run", channel, "displacement", "um", amplitude="rms")


def test_rows_of_empty_cells_are_no_rows(tmp_path):
    found = table(tmp_path, "f,a\n1,2\n,\n3,4\n , \n", "f", "a")
    assert found.numbers["a"].tolist() == [2, 4]
    with pytest.raises(MeasurementError, match='line 4: a = "": not a number; the cell is empty'):
        table(tmp_path, "f,a\n1,2\n,\n3,\n", "f", "a")


def test_a_low_line_is_no_part_of_a_number(tmp_path):
    with pytest.raises(MeasurementError, match='f = "1_000": not a number'):
        table(tmp_path, "f,a\n1_000,2\n1001,3\n", "f", "a")


@pytest.mark.parametrize(
    ("unit", "quantity", "wanted"),
    [("mil", "displacement", 25.4e-6), ("mils", "displacement", 25.4e-6), ("ips", "velocity", 0.0254)],
)
def test_units_of_the_united_states(unit: str, quantity: str, wanted: float) -> None:
    """A mil is no angle of artillery, as in pint."""
    assert si_factor(unit, quantity) == pytest.approx(wanted, rel=1e-12)
    assert label_factor(f"[{unit}]", quantity) == pytest.approx(wanted, rel=1e-12)
    assert label_factor(unit_and_kind(f"{unit} pk-pk")[0], quantity) == pytest.approx(wanted, rel=1e-12)
