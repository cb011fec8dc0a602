"""CSV files as programs of the laboratory write them give what the plain file gives: lines above the column names, a
row of units, Latin-1, UTF-16."""

from pathlib import Path

import numpy as np
import pytest
from support.measured_oscillator import FREQUENCY, TOML, recorded

from updamp.measurement.load import load_measurement
from updamp.measurement.measurement import Measurement, MeasurementError
from updamp.measurement.readers.csv_columns import ColumnOptions, read_csv_columns

FORCE, LASER = (recorded().channels[name].amplitude[0] for name in ("force", "laser"))
NAMES = ("Frequenz", "Kraft", "Kraft Phase", "Prüfling", "Prüfling Phase")
ROWS = np.column_stack(
    (FREQUENCY, np.abs(FORCE), np.degrees(np.angle(FORCE)), np.abs(LASER), np.degrees(np.angle(LASER)))
)
OPTIONS = 'frequency = "Frequenz", phase = { Kraft = "Kraft Phase", "Prüfling" = "Prüfling Phase" }, phase_unit = "deg"'
GERMAN = 'delimiter = ";", decimal = ","'
UNITS = ("[Hz]", "[N]", "[°]", "[mm/s]", "[°]")
PREAMBLE = (
    "Prüfstand 3;Datum: 03.05.2024;;;",
    "Bediener: Köhler",
    "Kanal 1, Kraftmessdose, 22,4 mV/N",
    '"Kanal 2: Laser 12" Abstand',
)


def text(delimiter: str = ";", decimal: str = ",", above: tuple[str, ...] = (), units: tuple[str, ...] = ()) -> str:
    rows = [delimiter.join(f"{x:.16g}".replace(".", decimal) for x in row) for row in ROWS.tolist()]
    below = [delimiter.join(units)] if units else []
    return "\r\n".join([*above, delimiter.join(NAMES), *below, *rows, ""])


def stated(folder: Path, options: str, change: tuple[str, str] = ("", "")) -> Path:
    toml = TOML.replace("[channels.force]", '[channels.force]\nlabel = "Kraft"', 1)
    toml = toml.replace("[channels.laser]", '[channels.laser]\nlabel = "Prüfling"', 1).replace(*change)
    tail = f'repeat = 1\nreader = "csv_columns"\nchannels = ["laser"]\noptions = {{ {OPTIONS}, {options} }}\n'
    path = folder / "measurement.toml"
    path.write_text(toml + tail, encoding="utf-8")
    return path


def load(
    folder: Path, content: str, options: str = GERMAN, encoding: str = "utf-8", change: tuple[str, str] = ("", "")
) -> Measurement:
    (folder / "data.csv").write_bytes(content.encode(encoding))
    return load_measurement(stated(folder, options, change))


def refused(folder: Path, content: str, options: str = GERMAN, change: tuple[str, str] = ("", "")) -> str:
    with pytest.raises(MeasurementError) as error:
        load(folder, content, options, change=change)
    return str(error.value)


def assert_same(one: Measurement, other: Measurement) -> None:
    (run,), (expected,) = one.runs, other.runs
    np.testing.assert_array_equal(run.frequency, expected.frequency)
    np.testing.assert_array_equal(run.force, expected.force)
    np.testing.assert_array_equal(run.response, expected.response)


def said(measurement: Measurement, words: str) -> str:
    (found,) = (sentence for sentence in measurement.assumptions if words in sentence)
    return found


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "cp1252", "utf-16"])
def test_a_german_export_reads_as_the_plain_file(tmp_path: Path, encoding: str) -> None:
    """Preamble with other delimiters and a lone quote, row of units, semicolons, decimal commas; every encoding."""
    plain = load(tmp_path, text())
    export = load(tmp_path, text(above=PREAMBLE, units=UNITS), encoding=encoding)
    assert_same(export, plain)
    above = said(export, "names of the columns")
    assert 'data.csv: line 5 has the names of the columns; the 4 lines above it, "Prüfstand 3;' in above
    units = said(export, "row of units")
    assert "line 6 is taken as the row of units and left out: 'Frequenz' Hz, 'Kraft' N" in units
    assert "'Prüfling' mm/s" in units
    told = [sentence for sentence in export.assumptions if "the text is" in sentence]
    assert len(told) == (0 if encoding.startswith("utf-8") else 1)
    assert all(("UTF-16" if encoding == "utf-16" else "Windows-1252") in sentence for sentence in told)


def test_unicode_text_of_a_spreadsheet(tmp_path: Path) -> None:
    """Excel's "Unicode text": UTF-16 with a byte order mark, tabs; the end of the file is not taken for cut off."""
    plain = load(tmp_path, text())
    content = text("\t", ",", units=UNITS)
    export = load(tmp_path, content, r'delimiter = "\t", decimal = ","', "utf-16")
    assert_same(export, plain)
    assert not any("line end" in sentence for sentence in export.assumptions)
    cut = load(tmp_path, content.rstrip("\r\n"), r'delimiter = "\t", decimal = ","', "utf-16")
    assert_same(cut, plain)
    assert said(cut, "line end")


def test_a_tabbed_export_with_a_long_head(tmp_path: Path) -> None:
    """As LabVIEW writes it: keys and values, marks of sections, an empty line, then the table."""
    head = (
        "LabVIEW Measurement\t", "Writer_Version\t2", "Separator\tTab", "Decimal_Separator\t.", "Date\t2024/05/03",
        "Time\t10:14:32.5197143478393554688", "***End_of_Header***\t", "", "Channels\t5\t\t\t\t", "Samples\t41\t41",
        "X_Dimension\tFrequency\tFrequency\tFrequency\tFrequency", "***End_of_Header***\t\t\t\t",
    )  # fmt: skip
    plain = load(tmp_path, text())
    export = load(tmp_path, text("\t", ".", head), r'delimiter = "\t"')
    assert_same(export, plain)
    assert "line 13 has the names of the columns; the 11 lines above it" in said(export, "names of the columns")


@pytest.mark.parametrize("above", [(), ("# Pruefstand 3", "# Messung 7, Sweep abwaerts", "")])
def test_names_of_columns_in_a_comment(tmp_path: Path, above: tuple[str, ...]) -> None:
    """As numpy.savetxt writes them."""
    head, *rows = text().split("\r\n")
    found = load(tmp_path, "\n".join([*above, f"# {head}", *rows]))
    assert_same(found, load(tmp_path, text()))
    said(found, f"line {len(above) + 1}, a comment, has the names of the columns")


def test_a_comment_that_lacks_a_column_is_none(tmp_path: Path) -> None:
    head, *rows = text().replace("Kraft Phase", "phase").split("\r\n")
    assert "no column" in refused(tmp_path, "\n".join([f"# {head}", *rows]))


def test_the_first_line_of_a_spreadsheet_that_states_the_delimiter(tmp_path: Path) -> None:
    export = load(tmp_path, text(above=("sep=;",)))
    assert_same(export, load(tmp_path, text()))
    assert 'the line above it, "sep=;", is left out' in said(export, "names of the columns")


def test_empty_columns_at_the_right_edge_are_passed_over(tmp_path: Path) -> None:
    """As a spreadsheet exports a sheet in which a cell to the right of the table was once used."""
    padded = "".join(f"{line};;\r\n" for line in text(above=PREAMBLE[:1], units=UNITS).splitlines())
    export = load(tmp_path, padded)
    assert_same(export, load(tmp_path, text()))
    assert not any("are not used" in sentence for sentence in export.assumptions)


def test_the_long_form_has_a_preamble_too(tmp_path: Path) -> None:
    columns = "run;frequency_Hz;channel;real;imag"
    lines = [
        f"B 17 N;{f:.16g};{name};{a.real:.16g};{a.imag:.16g}"
        for name, values in (("force", FORCE), ("laser", LASER))
        for f, a in zip(FREQUENCY, values, strict=True)
    ]
    (tmp_path / "measurement.toml").write_text(
        f'{TOML}repeat = 1\nchannels = ["laser"]\noptions = {{ delimiter = ";" }}\n'
    )
    loaded = []
    for above in ([columns], ["Title: a, b; c", "run;1", columns, "-;Hz;-;;"]):
        (tmp_path / "data.csv").write_text("\n".join([*above, *lines, ""]))
        loaded.append(load_measurement(tmp_path / "measurement.toml"))
    assert_same(loaded[1], loaded[0])
    assert "line 4 is taken as the row of units and left out: 'frequency_Hz' Hz" in said(loaded[1], "row of units")
    (tmp_path / "data.csv").write_text("\n".join([columns, "-;kHz;-;;", *lines, ""]))
    with pytest.raises(MeasurementError, match="'frequency_Hz': its row of units says kHz, it is read in Hz"):
        load_measurement(tmp_path / "measurement.toml")


def test_numbers_of_lines_count_the_preamble(tmp_path: Path) -> None:
    """An error names the line as an editor shows it: below preamble, empty lines, comments and units."""
    content = text(above=(*PREAMBLE, "", "# a comment"), units=UNITS)
    lines = content.split("\r\n")
    lines[17] = lines[17].replace(",", ".", 1)
    message = refused(tmp_path, "\r\n".join(lines))
    assert "data.csv: line 18: Frequenz = " in message
    lines = content.split("\r\n")
    lines[20] = lines[20].rsplit(";", 1)[0]
    assert "data.csv: line 21, " in refused(tmp_path, "\r\n".join(lines))
    spoilt = content.split("\r\n")
    cells = spoilt[30].split(";")
    spoilt[30] = ";".join([*cells[:3], f"-{cells[3]}", cells[4]])
    assert "data.csv: line 31: Prüfling = -" in refused(tmp_path, "\r\n".join(spoilt))


@pytest.mark.parametrize(
    ("units", "words"),
    [
        (("Hz", "N", "°", "m/s", "°"), ["channel 'laser': the file says m/s", 'unit = "mm/s"', "row of units"]),
        (("Hz", "N", "°", "m/s²", "°"), ["channel 'laser': the file says m/s²", "acceleration"]),
        (("Hz", "kN", "°", "mm/s", "°"), ["channel 'force': the file says kN", 'unit = "N"']),
        (("kHz", "N", "°", "mm/s", "°"), ["column 'Frequenz': its row of units says kHz, it is read in Hz"]),
        (("rad/s", "N", "°", "mm/s", "°"), ["column 'Frequenz': its row of units says rad/s"]),
        (("Hz", "N", "°", "mm/s", "rad"), ["column 'Prüfling Phase': its row of units says rad, it is read in deg"]),
    ],
)
def test_units_that_contradict_what_is_stated_are_refused(
    tmp_path: Path, units: tuple[str, ...], words: list[str]
) -> None:
    message = refused(tmp_path, text(above=PREAMBLE, units=units))
    for word in ("data.csv", *words):
        assert word in message, message


@pytest.mark.parametrize(
    "units",
    [
        ("(Hz)", "(N)", "(deg)", "(mm/s)", "(Grad)"), ("<hz>", "n", "", "MM/S", ""), ("1/s", "[N]", "-", "mm s-1", "-"),
    ],
)  # fmt: skip
def test_units_in_other_spellings_agree(tmp_path: Path, units: tuple[str, ...]) -> None:
    export = load(tmp_path, text(units=units))
    assert_same(export, load(tmp_path, text()))
    assert not any("not understood" in sentence for sentence in export.assumptions)


def test_units_that_say_nothing_are_noted(tmp_path: Path) -> None:
    export = load(tmp_path, text(units=("Linie", "EU", "-", "a.u.", "-")))
    assert_same(export, load(tmp_path, text()))
    note = said(export, "'a.u.' is")
    assert "channel 'laser': the file's unit 'a.u.' is not understood; mm/s is taken" in note


def test_a_row_of_numbers_is_no_row_of_units(tmp_path: Path) -> None:
    """Whatever their decimal sign, and whatever parts their thousands: the first line of numbers is never lost."""
    message = refused(tmp_path, text(), 'delimiter = ";"')
    assert "data.csv: line 3: Frequenz = " in message  # the first frequency is 428, without a comma
    assert 'decimal = ","' in message
    thousands = text().split("\r\n")
    thousands[1] = ";".join(["1.428,5"] * 5)
    assert 'line 2: Frequenz = "1.428,5": not a number' in refused(tmp_path, "\r\n".join(thousands))
    partly = text().split("\r\n")
    partly[1] = ";1;;;"
    assert 'line 2: Frequenz = "": not a number; the cell is empty' in refused(tmp_path, "\r\n".join(partly))


def test_the_delimiter_is_found_below_a_preamble(tmp_path: Path) -> None:
    """A preamble that has the delimiter of the reader does not hide that the table has another."""
    for content, other in ((text(above=PREAMBLE, units=UNITS), ";"), (text("\t", ".", PREAMBLE), r"\t")):
        message = refused(tmp_path, content, 'delimiter = ","')
        assert f'state in its run options = {{ delimiter = "{other}" }}' in message, message


def test_a_preamble_without_any_header(tmp_path: Path) -> None:
    content = text(above=PREAMBLE).replace(";".join(NAMES) + "\r\n", "")
    message = refused(tmp_path, content)
    for word in ("data.csv: no column 'Frequenz'", "there are"):
        assert word in message, message


def test_a_column_of_another_name_below_a_preamble(tmp_path: Path) -> None:
    """The error names what the table has, not what the preamble says, and the line."""
    message = refused(tmp_path, text(above=PREAMBLE).replace("Frequenz", "Frequnez"))
    assert "no column 'Frequenz'; did you mean Frequnez? (names of columns are looked for in line 5)" in message


def test_a_preamble_longer_than_any_program_writes(tmp_path: Path) -> None:
    assert "no column 'Frequenz'" in refused(tmp_path, text(above=("Messung",) * 600))


@pytest.mark.parametrize(
    "content", [b"\x7fELF\x02\x01\x01" + bytes(range(1, 256)) * 40, b"f;F\n1;2\n\x00\x00\x00", b"Pr\xfcf\x81\n" * 20]
)
def test_a_binary_file_is_no_text(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "data.csv").write_bytes(content)
    with pytest.raises(MeasurementError, match=r"data\.csv: no text .* name the reader that suits it"):
        load_measurement(stated(tmp_path, GERMAN))


def test_a_workbook_is_told_as_one(tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_bytes(b"PK\x03\x04 workbook.xml")
    with pytest.raises(MeasurementError, match=r"data\.csv: no text \(it is a zip archive, .* save the sheet as CSV"):
        load_measurement(stated(tmp_path, GERMAN))


def test_damaged_utf_16(tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_bytes(text().encode("utf-16")[:-1])
    with pytest.raises(MeasurementError, match=r"data\.csv: damaged text in UTF-16"):
        load_measurement(stated(tmp_path, GERMAN))


def test_the_documented_export_is_read_as_documented(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "measurements.md").read_text(encoding="utf-8")
    block = page[page.index("### Exports with a preamble") :].split("```")[1].lstrip("\n")
    (tmp_path / "data.csv").write_text(block, encoding="latin-1")
    options = ColumnOptions(delimiter=";", decimal=",")
    (sweep,) = read_csv_columns(tmp_path / "data.csv", ("force", "laser 1"), options)
    assert (sweep.frequency, sweep.channels["force"].amplitude, sweep.channels["laser 1"].unit) == (446, 16.98, "mm/s")
