"""Shared libraries that packages load and pip does not bring: which are missing here, and how to get them."""

import ctypes
from collections.abc import Mapping


def lacking(libraries: Mapping[str, str]) -> str:
    """What is missing and the command that gets it; "" where all is there. libraries: file -> Debian package"""
    missing = [file for file in libraries if not _loads(file)]
    if not missing:
        return ""
    packages = " ".join(dict.fromkeys(libraries[file] for file in missing))
    return f"{', '.join(missing)} missing; apt-get install {packages} (Debian, Ubuntu)"


def _loads(file: str) -> bool:
    try:
        ctypes.CDLL(file)
    except OSError:
        return False
    return True
