"""Problems solved by other codes, kept in tests/hbm/reference."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from updamp.hbm.contact.friction import FrictionParameters
from updamp.hbm.contact.law import ContactLaw
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.problem.elements import ElementGroup
from updamp.hbm.problem.linear_model import LinearModel, from_matrices
from updamp.hbm.problem.system import NonlinearSystem

FOLDER = Path(__file__).parents[1] / "hbm" / "reference"


@cache
def solved(name: str) -> Any:
    return json.loads((FOLDER / f"{name}.json").read_text())


def friction(n: int, mu: float, kt: float, kn: float, n0: np.ndarray) -> FrictionParameters:
    every = np.ones(n)
    return FrictionParameters(mu * every, kt * every, kn * every, n0, np.zeros((n, 2)), 0 * every)


@cache
def blades_and_damper() -> tuple[LinearModel, FrictionParameters]:
    d = np.load(FOLDER / "c_model_20.npz")
    linear = from_matrices(d["M"], d["C"], d["K"], d["Q"], {"excitation": d["F"], "tip": d["out"]})
    return linear, friction(int(d["ne"]), float(d["mu"]), float(d["kt"]), float(d["kn"]), d["N0"])


def blades_and_damper_system(
    law: ContactLaw, orders: tuple[int, ...] = (0, 1, 2, 3), n_time: int = 128
) -> NonlinearSystem:
    linear, parameters = blades_and_damper()
    rows = np.arange(linear.n_relative).reshape(-1, 3)
    return NonlinearSystem(linear, (ElementGroup(law, parameters, rows),), Harmonics(orders), n_time)


def one_degree_of_freedom(
    c: float, group: ElementGroup, orders: tuple[int, ...], n_time: int, mean_held: bool = False
) -> NonlinearSystem:
    one = np.eye(1)
    linear = from_matrices(one, c * one, one, one, {"mass": one[0]})
    return NonlinearSystem(linear, (group,), Harmonics(orders), n_time, mean_held=mean_held)
