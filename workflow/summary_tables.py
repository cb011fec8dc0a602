"""What a run found as tables on the terminal, from what summary.json holds."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from updamp.workflow.accuracy_summary import error_cells
from updamp.workflow.marching_summary import marching_remark

LEAST_WIDTH = {
    "force N": 5,
    "peak mm/N": 7,
    "at Hz": 6,
    "error %": 6,
    "error Hz": 6,
    "jumps Hz": 11,
    "": 8,
}  # numbers are not cut off


def _curve_cells(entry: Mapping[str, Any], with_error: bool, with_harmonics: bool) -> list[str]:
    return [
        entry["mode"],
        f"{entry['force_N']:g}",
        f"{entry['peak_receptance_mm_per_N']:.5f}" if entry["points"] else "",
        f"{entry['peak_frequency_Hz']:.2f}" if entry["points"] else "",
        *(error_cells(entry.get("numerical_error")) if with_error else ()),
        *((str(entry["harmonics"][-1]),) if with_harmonics else ()),
        "\n".join(f"{f:.2f} {way}" for way in ("up", "down") for f in entry.get(f"jumps_{way}_Hz", ())),
        str(entry["points"]),
        f"{entry['seconds']:.0f}",
        _remark(entry),
    ]


def curves_table(entries: Sequence[Mapping[str, Any]]) -> Table:
    """Nothing is cut off in a terminal of 80 columns; each jump has a line of its own."""
    table = Table(
        title="Response curves",
        title_justify="left",
        header_style="bold",
        box=SIMPLE_HEAD,
        padding=0,
        pad_edge=False,
    )
    known = [entry["numerical_error"] for entry in entries if entry.get("numerical_error")]
    chosen = any(entry.get("harmonics_chosen") for entry in entries)
    headings = ["mode", "force N", "peak mm/N", "at Hz", "jumps Hz", "points", "s", ""]
    for heading in (
        *headings[:4],
        *(("error %", "error Hz") if known else ()),
        *(("harm.",) if chosen else ()),
        *headings[4:],
    ):
        table.add_column(
            heading.replace(" ", "\n"),
            justify="left" if heading in ("mode", "") else "right",
            min_width=LEAST_WIDTH.get(heading),
            overflow="fold",
        )
    for entry in entries:
        table.add_row(*_curve_cells(entry, bool(known), chosen))
    if known:
        orders = next((one["orders"] for one in known if one["orders"]), ())
        which = f"harmonics {', '.join(map(str, orders))}" if orders else "further harmonics"
        mean = "; what the mean position (harmonic 0) changes is not in it" if orders and 0 not in orders else ""
        table.caption = f"error: what {which} change, of the peak's height and frequency{mean}"
    return table


def _remark(entry: Mapping[str, Any]) -> str:
    peak = (entry.get("stability") or {}).get("peak")
    remarks = ["[red]not complete[/]"] if entry["problem"] else []
    remarks += ["[red]unstable[/]"] if peak == "unstable" else []
    remarks += ["stable?"] if peak == "unknown" else []
    remarks += marching_remark(entry)
    higher = any(
        one["peak_receptance_mm_per_N"] > entry["peak_receptance_mm_per_N"] for one in entry.get("detached", ())
    )
    remarks += ["[red]higher beside it[/]"] if higher else []
    return ", ".join(remarks)


def overview_table(summary: Mapping[str, Any]) -> Table:
    """Everything but the curves: name and value, as far as the run has come."""
    table = Table(show_header=False, box=None, padding=(0, 2, 0, 0))
    for section, values in summary.items():
        if isinstance(values, Mapping):
            for name, value in values.items():
                table.add_row(f"{section}.{name}", _short(value))
        elif section in ("not_checked", "misnamed_modes"):
            for sentence in values:
                table.add_row(section, sentence)
        elif section != "curves":
            table.add_row(section, _short(values))
    return table


def _short(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_short(entry)}" for name, entry in value.items())
    return f"{value:.6g}" if isinstance(value, float) else str(value)
