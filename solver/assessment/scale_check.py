"""The size of the calibrated arm, and the distance between the sockets that it rests on."""

from collections.abc import Sequence

from ..diagnostics import OF_JOINTS, Diagnostic, size_level
from ..results import PlacementErrors, Scale
from .formatting import joined, short_names
from .limits import LimitResult, Status

_SOURCES = {
    "given": "as given",
    "recording": "as the recording says",
    "located": "by the sockets' coordinates",
    "default": "the default, since nothing says otherwise: measure it, and give it by --distance",
}


def distance_text(placements: Sequence[PlacementErrors]) -> str:
    """Return which distances between sockets the scale rests on, and where they are from."""
    trained = [row for row in placements if row.role == "train" and len(row.samples) > 1]
    points = [row.name for row in placements if row.role == "train" and row.kind == "points"]
    kinds: dict[tuple[str, str | None], list[str]] = {}
    for name, row in zip(short_names([row.name for row in trained]), trained, strict=True):
        kinds.setdefault((_mm(row.distance or 0.0), row.distance_source), []).append(name)
    parts: list[str] = []
    for (distance, source), names in kinds.items():
        place = f" at {joined(names)}" if len(kinds) > 1 else ""
        origin = f" ({_SOURCES[source]})" if source in _SOURCES else ""
        parts.append(f"{distance} mm{place}{origin}")
    if not parts and points:
        return f"Scale: from the points that an instrument measured at {joined(points)}."
    if not parts:
        return "Distance of the sockets: none in the placements trained on."
    return f"Distance of the sockets: {'; '.join(parts)}."


def scale_text(scale: Scale) -> str:
    """Return by how much the arm came out larger or smaller, in words."""
    size = f"{abs(100 * scale.value):.2f} % {'longer' if scale.value > 0 else 'shorter'}"
    known = "" if scale.deviation is None else f" (+- {100 * scale.deviation:.2f} %)"
    return f"the arm came out {size}{known} than its model"


def joints_wrong(checks: Sequence[Diagnostic] | None) -> bool:
    """Tell whether a joint's sign, order or zero, which comes before the distance, is wrong."""
    return any(check.code in OF_JOINTS for check in checks or ())


def scale_row(
    scale: Scale, placements: Sequence[PlacementErrors], checks: Sequence[Diagnostic] | None = None
) -> LimitResult:
    """Return whether the arm's size is believable, and what is more likely where it is not."""
    level = size_level(scale.value, scale.deviation)
    statuses: dict[str | None, Status] = {
        None: "pass",
        "warning": "warning",
        "unknown": "not enough",
        "error": "fail",
    }
    status = statuses[level]
    text = scale_text(scale)
    spaced = any(row.role == "train" and row.distance for row in placements)
    if status != "pass" and joints_wrong(checks):
        text += "; the joints explain it, see the data checks: mend them before the distance"
    elif status != "pass" and not spaced:
        text += "; check that the measured points are in metres"
    elif status == "not enough":
        text += (
            ", and may be as long as it; record more samples, at a second place, or with sockets "
            "farther apart"
        )
    elif status != "pass":
        distance, likely = _trained_distance(placements), likely_distance(scale, placements)
        text += f"; more likely the sockets are {_tenth(likely, distance)} mm apart than "
        text += f"{_tenth(distance, likely)}: measure them, and give it by --distance"
    return LimitResult(
        name="scale",
        title="size of the arm",
        found=None,
        limit=None,
        status=status,
        text=text,
        reason=f"{text[0].upper()}{text[1:]}",
    )


def likely_distance(scale: Scale, placements: Sequence[PlacementErrors]) -> float:
    """Return the distance of the sockets by which the arm would have its nominal size [m]."""
    return _trained_distance(placements) / max(1 + scale.value, 0.1)


def _trained_distance(placements: Sequence[PlacementErrors]) -> float:
    rows = (row.distance for row in placements if row.role == "train")
    return next((distance for distance in rows if distance), 0.0)


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.2f}".rstrip("0").rstrip(".")


def _tenth(metres: float, other: float) -> str:
    """Return millimetres with as many decimals as tell two lengths apart."""
    digits = 1 if abs(metres - other) >= 2e-4 else 2
    return f"{1e3 * metres:.{digits}f}"
