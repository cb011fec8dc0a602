"""Libraries of the extra "design", loaded by who asks for them: they take a second each, and need not be there."""

from importlib import import_module
from typing import Any


def library(name: str) -> Any:
    """The module. raises: ValueError with what to install"""
    try:
        return import_module(name)
    except ImportError as error:
        package = name.partition(".")[0]
        raise ValueError(f"{package} is not installed; install it with `pip install 'updamp[design]'`") from error
