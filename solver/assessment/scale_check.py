"""The size of the calibrated arm, and the distance between the sockets that it rests on."""

from collections.abc import Sequence

from msgspec.structs import replace

from ..diagnostics import OF_JOINTS, SIZE_BY_DISTANCE, SIZE_BY_MODEL, size_level
from ..results import (
    CalibrationDocument,
    Diagnostic,
    Hypothesis,
    PlacementErrors,
    Scale,
)
from .formatting import joined, short_names
from .limits import READING, TITLES, LimitResult, Status, limit_row
from .verdict import Premise

STEP = 1e-4
"""Change of a distance between sockets whose effect is named [m]."""
_MOVED = {"moved": "the base moved", "drift": "the base drifted"}
"""Diagnostics that leave the distance of the sockets, and so the size, unknown."""
HOLDS = 0.01
"""Share within which a fit has the arm's size, so that a length is likelier than a distance."""
IMPOSSIBLE = 0.05
"""Share by which no arm is longer or shorter than its model: the distance is wrong."""
OF_MODEL = ("length", "angle", "version")
"""Causes in the numbers of the URDF."""
LIKELY_MODEL = 0.1
"""Probability of these from which they are likelier than so small an error of a distance."""
INSTRUMENT_SCALE = 0.015
"""Largest scale that an instrument, or an arm, is off by; more is another unit."""
DOUBTED = 0.01
"""Probability of such a cause from which it is no small one."""
MOVEMENTS = (*_MOVED, "movement")
"""Codes of findings by which something was not firm."""
_TYPED = {
    "given": "your {:.5g} mm",
    "recording": "the {:.5g} mm in placement.json",
    "located": "the {:.5g} mm between the coordinates",
}
_SOURCES = {
    "given": "as given",
    "recording": "as the recording says",
    "located": "by the sockets' coordinates",
    "default": "the default: nobody measured it",
}


def distance_text(placements: Sequence[PlacementErrors]) -> str:
    """Return which distances between sockets the scale rests on, and where they are from."""
    rows = _with_distance(placements)
    points = [
        row.name for row in placements if row.role == "train" and row.kind == "points"
    ]
    kinds: dict[tuple[str, str | None], list[str]] = {}
    for name, row in zip(short_names([row.name for row in rows]), rows, strict=True):
        key = f"{1e3 * (row.distance or 0.0):.5g}", row.distance_source
        kinds.setdefault(key, []).append(name)
    parts: list[str] = []
    for (distance, source), names in kinds.items():
        place = f" at {joined(names)}" if len(kinds) > 1 else ""
        origin = f" ({_SOURCES[source]})" if source in _SOURCES else ""
        parts.append(f"{distance} mm{place}{origin}")
    if not parts and points:
        return f"Lengths are the instrument's, at {joined(points)}."
    if not parts:
        return "Distance of the sockets: none in the placements trained on."
    return f"Distance of the sockets: {'; '.join(parts)}."


def scale_text(scale: Scale) -> str:
    """Return by how much the arm came out larger or smaller, in words."""
    size = (
        f"{abs(100 * scale.value):.2f} % {'longer' if scale.value > 0 else 'shorter'}"
    )
    interval = "" if scale.deviation is None else f" (+- {100 * scale.deviation:.2f} %)"
    return f"the arm came out {size}{interval} than its model"


def joints_wrong(checks: Sequence[Diagnostic] | None) -> bool:
    """Tell whether a joint's sign or order, which comes before the distance, is wrong."""
    return any(c.code in OF_JOINTS and c.level == "error" for c in checks or ())


def rests_on(document: CalibrationDocument) -> list[Premise]:
    """Return the premises of an answer that no recording can test."""
    premises: list[Premise] = []
    for placement in _with_distance(document.placements):
        source = _source(placement, document)
        if placement.distance is None or source not in _TYPED:
            continue
        effect = STEP / placement.distance
        twice = ", read twice" if (placement.distance_readings or 1) > 1 else ""
        text = (
            f"This relies on {_TYPED[source].format(1e3 * placement.distance)}{twice}: measured "
            f"{1e3 * STEP:g} mm too short, every length is {100 * effect:.1g} % too short."
        )
        premise = Premise(
            name="distance",
            text=text,
            value=placement.distance,
            source=source,
            effect=effect,
        )
        premises += [premise] if premise not in premises else []
    kinds = {row.kind for row in document.placements if row.role == "train"}
    if "points" in kinds:
        text = "This relies on the instrument's lengths, which these data cannot test."
        premises.append(Premise(name="instrument", text=text))
    moved = any(check.code in MOVEMENTS for check in document.checks or ())
    if "sockets" in kinds and not moved:
        text = "Ball, base and table must have been firm."
        premises.append(Premise(name="firm", text=text))
    return premises


def distance_row(assumed: Sequence[float]) -> LimitResult:
    """Return whether the arm's size rests on distances that nobody measured, ``assumed`` [m]."""
    if not assumed:
        return limit_row("distance_given", "pass", "not assumed")
    text = (
        f"nobody measured the distance of the sockets, and {1e3 * assumed[0]:.5g} mm is assumed; "
        "measure it from centre to centre with a caliper (page print of the docs), and add "
        "--distance 50.1mm if you read 50.1 mm"
    )
    return limit_row("distance_given", "not enough", text)


def assumed_distances(document: CalibrationDocument) -> list[float]:
    """Return the distances trained on that neither a person nor a recording said [m]."""
    rows = _with_distance(document.placements)
    return [row.distance or 0.0 for row in rows if _source(row, document) not in _TYPED]


def measured_distances(document: CalibrationDocument) -> set[float]:
    """Return the distances trained on that a person or a recording said [m]."""
    rows = _with_distance(document.placements)
    return {row.distance or 0.0 for row in rows if _source(row, document) in _TYPED}


def most_readings(placements: Sequence[PlacementErrors]) -> int:
    """Return how many readings agree on the distance of a placement trained on, at the most."""
    return max(
        (row.distance_readings or 1 for row in _with_distance(placements)), default=1
    )


def _with_distance(placements: Sequence[PlacementErrors]) -> list[PlacementErrors]:
    """Return the placements trained on that have a distance between sockets."""
    return [row for row in placements if row.role == "train" and row.has_distance]


def _source(placement: PlacementErrors, document: CalibrationDocument) -> str | None:
    """Return where a placement's distance is from; older files say it in their settings alone."""
    typed_by_user = document.settings.get("distance") is not None
    return placement.distance_source or ("given" if typed_by_user else None)


def distortion_row(document: CalibrationDocument) -> LimitResult:
    """Return whether the model reproduces the sockets' distance where it was trained on."""
    if not document.distorted:
        return limit_row("distortion", "pass", "within the scatter of the samples")
    text = (
        "the calibrated model does not reproduce the sockets' distance at "
        f"{', '.join(document.distorted)}; it has shrunk or bent to bring the samples together"
    )
    return limit_row("distortion", "fail", text, text=text)


def scale_row(
    scale: Scale,
    distance: float,
    checks: Sequence[Diagnostic] | None,
    causes: Sequence[Hypothesis] = (),
    *,
    readings: int = 1,
    settled: bool = False,
) -> LimitResult:
    """Return whether the arm's size is believable, and what else may explain it where it is not.

    What is wrong in the URDF explains it, unless a wrong distance is a probable cause as well. It
    hangs on a ``distance`` between sockets [m] and the ``readings`` that agree on it; 0 where an
    instrument measured points, whose scale is ``settled`` where the user gave it. Two readings are
    believed: it is then the model that is wrong.
    """
    level = size_level(scale.value, scale.deviation, distance, readings)
    text = scale_text(scale)
    if level is None:
        errors = [c.code for c in checks or () if c.level == "error"]
        moved = [code for code in errors if code in _MOVED]
        if moved:
            reason = (
                f"{_MOVED[moved[0]]} while it was recorded, so nothing is known of it"
            )
            return limit_row("scale", "not evaluated", reason)
        return _row_of_size("pass", text)
    explained = _explained_by_model(checks or (), causes)
    if explained:
        return _row_of_size("warning", f"{text}; the URDF explains it: {explained}")
    if joints_wrong(checks):
        text += "; the joints explain it, see the data checks: mend them before the distance"
        return _row_of_size("fail", text)
    if not distance and abs(scale.value) < INSTRUMENT_SCALE:
        if not settled:
            text += (
                ": the instrument's lengths are, or the arm's. Measure a known length by it: "
                f"--scale {1 + scale.value:.4f} if it comes out so much too long, --scale 1 if not"
            )
        return _row_of_size("warning", text)
    if not distance:
        text += "; check that the measured points are in metres"
        return _row_of_size("fail" if level == "error" else "not enough", text)
    if level == "unknown":
        text += (
            ", and may be as long as it; record more samples, at a second place, or with sockets "
            "farther apart"
        )
        return _row_of_size("not enough", text)
    text += _likely_distance(scale, distance, readings)
    if abs(scale.value) > IMPOSSIBLE:
        return _row_of_size("fail", text)
    if readings > 1:
        return _row_of_size("warning", text)
    row = _row_of_size("not enough", text)
    if _is_rather_a_length(scale, causes):
        return replace(row, name=READING, title=TITLES[READING])
    return row


def _is_rather_a_length(scale: Scale, causes: Sequence[Hypothesis]) -> bool:
    """Tell whether a number of the URDF may be wrong, where the fit has the arm's size nearly."""
    by_model = [cause.probability for cause in causes if cause.name in OF_MODEL]
    return abs(scale.value) <= HOLDS and sum(by_model) >= LIKELY_MODEL


def _row_of_size(status: Status, text: str) -> LimitResult:
    """Return the row of the arm's size, whose reason is its text as a sentence begins."""
    return limit_row("scale", status, f"{text[0].upper()}{text[1:]}", text=text)


def _explained_by_model(
    checks: Sequence[Diagnostic], causes: Sequence[Hypothesis]
) -> str:
    """Return what is wrong in the URDF and explains the size; empty where a distance may, too."""
    doubtful = [c for c in causes if c.fits_as_well or c.probability > DOUBTED]
    by_distance = any(cause.name in SIZE_BY_DISTANCE for cause in doubtful)
    if by_distance or joints_wrong(checks):
        return ""
    for check in checks:
        is_of_size = check.level == "warning" and check.code in SIZE_BY_MODEL
        if is_of_size and (check.code != "model" or check.consequence is not None):
            return check.text
    return ""


def _likely_distance(scale: Scale, distance: float, readings: int) -> str:
    """Return in words which distance of the sockets would give the model's size, distance / s."""
    likely = distance / max(1 + scale.value, 0.1)
    digits = 1 if abs(likely - distance) >= 2e-4 else 2
    text = (
        f": the sockets are {1e3 * likely:.{digits}f} mm apart, or every length of the model "
        f"is {abs(100 * scale.value):.2f} % off"
    )
    if readings > 1:
        return f"{text}, though the distance was read twice"
    cure = (
        "measure again, and type both readings, as --distance FIRST --distance SECOND"
    )
    return f"{text}: {cure}"
