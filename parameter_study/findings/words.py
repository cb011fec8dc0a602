"""Numbers as the findings' sentences have them."""


def percent(share: float, digits: int = 0) -> str:
    """A change, with its sign."""
    return f"{100 * share:+.{digits}f} %"


def share(value: float) -> str:
    return f"{100 * value:.0f} %"


def mm(receptance: float) -> str:
    """receptance: [m/N]"""
    return f"{1e3 * receptance:.5f}"
