"""Lengths in words, the same wherever they are told."""


def mm(metres: float, digits: int = 2) -> str:
    """Return a length in millimetres."""
    return f"{fixed(1e3 * metres, digits)} mm"


def millimetres(metres: float | None, digits: int = 3) -> str:
    """Return a length in millimetres without its unit, as it stands in tables; - for None."""
    return "-" if metres is None else f"{1e3 * metres:.{digits}f}"


def fixed(value: float, digits: int, sign: str = "") -> str:
    """Return a number with so many decimals; zero has no minus."""
    return f"{round(value, digits) + 0.0:{sign}.{digits}f}"
