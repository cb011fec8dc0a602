"""Libraries of the extra "design", loaded by who asks for them: they take a second each, and need not be there."""

from importlib import import_module
from typing import Any


def library(name: str, package: str = "'updamp[design]'") -> Any:
    """The module. package: that pip installs it with; raises: ValueError with what to install"""
    try:
        return import_module(name)
    except ImportError as error:
        raise ValueError(f"{name.partition('.')[0]} is not installed; get it with `pip install {package}`") from error
