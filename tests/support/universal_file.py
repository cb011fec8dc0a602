"""The measured oscillator as text of data set 58, so that every field can be anything."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from support.measured_oscillator import FREQUENCY, TOML, displacement, force

POUND = 4.4482216152605  # N, exact by definition (NIST SP 811, appendix B.8)
FORCE, VELOCITY, ACCELERATION, NOTHING = (13, "N"), (11, "mm/s"), (12, "m/s^2"), (0, "NONE")
UFF_TOML = (
    TOML.replace("data.csv", "data.uff")
    .replace('"rms"', '"peak"')
    .replace('"g_0"', '"m/s^2"')
    .replace('direction = "-x"', 'direction = "x"')
    .replace('unit = "N"', 'unit = "N"\nlabel = "1+X"')
    .replace('unit = "mm/s"', 'unit = "mm/s"\nlabel = "3+X"')
    .replace('unit = "m/s^2"', 'unit = "m/s^2"\nlabel = "2+X"')
)
W = 2 * np.pi * FREQUENCY


def measured() -> dict[str, NDArray[np.complex128]]:
    """(n,) of force [N], acceleration [m/s^2] and velocity [mm/s], peak."""
    x = displacement()[0]
    return {"force": force(), "acceleration": -(W**2) * x, "velocity": 1e3j * W * x}


def record(data: NDArray[Any], x: NDArray[np.float64] = FREQUENCY, **fields: Any) -> str:
    """One data set 58, uneven unless even = True, double precision.

    fields: function, version, response and reference (node, direction), first, second (lines), abscissa, ordinate,
        below, z (type, unit)
    """
    f = {
        "function": 12, "version": 0, "response": (1, 1), "reference": (0, 0), "first": "NONE", "second": "NONE",
        "abscissa": (18, "Hz"), "ordinate": FORCE, "below": NOTHING, "even": False,
    } | fields  # fmt: skip
    (node, toward), (ref_node, ref_toward) = f["response"], f["reference"]
    spacing = (x[0], x[1] - x[0]) if f["even"] else (0.0, 0.0)
    lines = [
        "    -1", "    58", f["first"], f["second"], "NONE", "NONE", "NONE",
        f"{f['function']:5d}{0:10d}{f['version']:5d}{0:10d} {'NONE':<10}{node:10d}{toward:4d} {'NONE':<10}"
        f"{ref_node:10d}{ref_toward:4d}",
        f"{6 if np.iscomplexobj(data) else 4:10d}{len(data):10d}{int(f['even']):10d}"
        f"{spacing[0]:13.5E}{spacing[1]:13.5E}{0:13.5E}",
    ]  # fmt: skip
    for kind, unit in (f["abscissa"], f["ordinate"], f["below"], NOTHING):
        lines.append(f"{kind:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {unit:<20}")
    parts = [data.real, data.imag] if np.iscomplexobj(data) else [data]
    rows = np.array(parts).T if f["even"] else np.array([x, *parts]).T
    lines += [_numbers(row, f["even"]) for row in rows]
    return "\n".join([*lines, "    -1", ""])


def _numbers(row: NDArray[np.float64], even: bool) -> str:
    widths = ["20.12E"] * 4 if even else ["13.5E", "20.12E", "20.12E"]
    return "".join(format(value, width) for value, width in zip(row, widths, strict=False))


def spectra(**fields: Any) -> str:
    """Force, acceleration and velocity at nodes 1 to 3."""
    data = measured()
    return "".join(
        record(data[name], response=(node, 1), ordinate=kind, **fields)
        for node, (name, kind) in enumerate(
            (("force", FORCE), ("acceleration", ACCELERATION), ("velocity", VELOCITY)), 1
        )
    )


def ratios(reference: tuple[int, int] = (1, 1), below: str = "N", scale: float = 1.0, **fields: Any) -> str:
    """Acceleration and velocity over force, in m/s^2 and mm/s to one `below`, times the scale."""
    data = measured()
    parts: Sequence[tuple[str, int, tuple[int, str]]] = (
        ("acceleration", 2, fields.pop("acceleration", ACCELERATION)), ("velocity", 3, VELOCITY),
    )  # fmt: skip
    return "".join(
        record(
            data[name] / data["force"] * scale, function=4, response=(node, 1), reference=reference, ordinate=kind,
            below=(13, below), **fields,
        )
        for name, node, kind in parts
    )  # fmt: skip


def units(length: float, newton: float) -> str:
    """Data set 164."""
    numbers = f"{length:25.17E}{newton:25.17E}{1:25.17E}\n{273.15:25.17E}".replace("E", "D")
    return f"    -1\n   164\n{5:10d}{'units':<20}{2:10d}\n{numbers}\n    -1\n"
