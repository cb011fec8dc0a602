"""The example of a system given by matrices: what it prints belongs together."""

import runpy
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_system.py"


@pytest.fixture(scope="module")
def said() -> list[str]:
    with redirect_stdout(StringIO()) as printed:
        runpy.run_path(str(EXAMPLE), run_name="__main__")
    return printed.getvalue().splitlines()


def test_the_curve_is_complete_and_its_numerical_error_small(said: list[str]) -> None:
    assert said[0] == "complete"
    assert abs(float(said[3].split()[-2])) < 0.1
    assert said[4].startswith("{'unknown': 0, ")


def test_the_resonance_by_force_meets_the_curve(said: list[str]) -> None:
    """From 0.5 N on, where the contact slips since 0.058 N: between points that lie far apart on the resonance no force
    was met, since their chord is too far from it."""
    *_, at, _, peak, _ = said[1].split()
    of_force = {words[2]: words for line in said[5:] for words in [line.split()]}
    assert list(of_force) == ["0.5", "1", "2", "5", "10"]
    assert float(of_force["5"][4]) == pytest.approx(float(at), abs=1e-3)
    assert float(of_force["5"][6]) == pytest.approx(float(peak), rel=1e-3)
