"""What is said of a run's memory counts every product there can be."""

from dataclasses import fields
from pathlib import Path
from typing import Any

from updamp.workflow.products import Products, Stored
from updamp.workflow.store import Stamp


def test_every_product_s_stamp_is_known() -> None:
    number = iter(range(100))

    def stored() -> Any:
        return Stored(Path(), None, Stamp("", peak_memory=float(next(number))))

    others = ("failures", "unknown", "left", "named_modes")
    kinds = {one.name: one.default for one in fields(Products) if one.name not in others}
    products = Products(
        **{name: (stored(), stored()) if default == () else stored() for name, default in kinds.items()}
    )
    assert sorted(stamp.peak_memory for stamp in products.stamps) == list(range(next(number)))
