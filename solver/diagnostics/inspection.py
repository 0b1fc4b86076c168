"""Inspection of recordings before a fit: each placement, all of them together, and the next one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from ..data import Measurement
from ..results import Diagnostic, Hypothesis
from ..robot import Robot
from .configurations import of_placement, row_of, where_of
from .consequence import consequence_of, level_of, nominal_errors
from .corrections import PLAY_HINT, Correction, correction_of
from .explain import MENDER, Given, explain, scene_loaded
from .hypotheses import KINDS, Candidate
from .robust_fit import RigidModel

SEATED = 0.03
"""Distance from its socket [m] beyond which a ball was elsewhere, not just badly seated."""
LEAST_GAIN = 2e-3
"""Gears have some hundred teeth: a wrong ratio is off by more than this share, an uneven joint
may look like less."""
SMALLEST_MOVE = 7.5e-4
"""A base that is knocked moves by more than this [m]; less may be how the arm was guided."""
UNWEIGHED = (
    *("distance", "scaled", "one_socket", "known", "copies", "repeated", "unexplained"),
    *("stuck", "uneven", "soft_base"),
)
"""Explanations that no fit with them and without them compares: of typed distances, of what the
fit has as well, or of samples that tell nothing."""
FITTED = ("length", "angle", "version", "zero")
"""Causes whose numbers are unknowns of the fit: how well it has them, the errors say, unless the
samples scatter like those of gears with play, which hides zeros."""
MOST_DRIFT, PLAY = 3e-3, 0.015
"""Drifts over a placement below this are no error [m], since the fit holds them, nor what looks
like one where gears have play."""
MOST_NOISE = 5e-3
"""Unexplained noise below this, and less than half of the nominal errors, is no error [m]."""
GARBAGE = 1e-2
"""What a placement fitted alone leaves beyond this is no recording of a ball in a socket [m]."""
LOOSE = 5e-4
"""Noise from which gears with play are suggested as the cause [m]."""
UNCLEAR = {"ball_loose", "pushed", "unexplained", "other_arm", "drift"}
"""Causes that several faults look like, which each placement may tell by itself."""
MANY = 5.0
"""A placement fitted alone that leaves more than so many times what the arm repeats is not sound,
though nothing explains it."""
HELD_OUT = "; it is held out: the model has none of it, the errors measured there have"
"""Added to the advice on what is weighed by the model in a placement to train on."""
POINTS_HINT = (
    "Measured points need no socket: "
    "spread the next ones over the workspace, and hold some out."
)
NOT_PLAY = ("socket", "sign", "swap", "order", "ball_sample", "one_socket")
"""Causes that cannot be confused with play."""


@dataclass(frozen=True)
class Inspection:
    """Diagnostics of one placement."""

    measured: Measurement
    floor: float
    """Mean error of a fit to this placement alone, see :func:`.explain.fitted_alone` [m]."""
    corrections: tuple[Correction, ...]
    """Actions that set its findings right."""
    diagnostics: tuple[Diagnostic, ...]
    centre: np.ndarray
    """Between its sockets, as the fit to all placements predicts it, shape (3,) [m]."""

    @property
    def sound(self) -> bool:
        """True without diagnostics that are errors."""
        return all(diagnostic.level != "error" for diagnostic in self.diagnostics)


@dataclass(frozen=True)
class Survey:
    """Diagnostics of several placements, and what explains them."""

    placements: tuple[Inspection, ...]
    shared: tuple[Diagnostic, ...]
    """Diagnostics of all placements, or of the arm."""
    hypotheses: tuple[Hypothesis, ...] = ()
    """Explanations of all recordings, the most probable first."""
    causes: tuple[str, ...] = ()
    """Names of the explanations that were accepted, each beside those before."""
    gains: tuple[str, ...] = ()
    """Joints that read too much or too little by a share."""

    @property
    def unclear(self) -> bool:
        """True where samples scatter, maybe since several placements have faults of their own."""
        corrections = chain.from_iterable(one.corrections for one in self.placements)
        corrected = any(one.action != "follow" for one in corrections)
        return not corrected and not UNCLEAR.isdisjoint(self.causes)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All diagnostics, those of all placements first."""
        return (
            *self.shared,
            *chain.from_iterable(one.diagnostics for one in self.placements),
        )


def inspect_all(
    robot: Robot,
    measurements: Sequence[Measurement],
    given: Given | None = None,
    *,
    zeros: bool = False,
    repeatability: float | None = None,
) -> Survey:
    """Inspect placements: each by itself, and all together.

    Args:
        robot: The robot.
        measurements: The placements.
        given: What was said of them.
        zeros: The joints may have offsets of degrees, as on arms made of servos: then that is no
            mistake.
        repeatability: Of the arm [m]; None where nothing is known of it.

    Raises:
        KnownError: A known distance names a socket that is not there.
    """
    given = given or Given()
    if not measurements:
        return Survey((), ())
    model = RigidModel(robot, zeros=zeros)
    scene = scene_loaded(model, measurements, given, repeatability)
    findings, hypotheses = explain(model, scene)
    told = [(f, _diagnostic(f, measurements, given, zeros=zeros)) for f in findings]
    explained = any(
        _explains_errors(finding, diagnostic) for finding, diagnostic in told
    )
    balls = model.points(scene.x, scene.q)
    inspections: list[Inspection] = []
    for m, rows, floor in zip(measurements, scene.places, scene.floors, strict=True):
        here = [(f, d) for f, d in told if f.parameters.get("placement") == m.name]
        corrections = filter(None, (correction_of(f, d, m) for f, d in here))
        diagnostics = [*(d for _, d in here), *of_placement(robot, m)]
        if floor > MANY * scene.noise and not explained:
            worst = int(np.argmax(np.linalg.norm(scene.remaining[rows], axis=1)))
            diagnostics.append(_unexplained(m, floor, scene.noise, worst))
        centre = np.median(balls[rows], axis=0)
        inspections.append(
            Inspection(m, floor, (*corrections,), (*diagnostics,), centre)
        )
    return Survey(
        tuple(inspections),
        shared=tuple(d for f, d in told if f.of_all),
        hypotheses=tuple(
            replace(h, advice=_by_mender(h.advice, given)) for h in hypotheses
        ),
        causes=tuple(finding.kind.name for finding in findings),
        gains=tuple(f.parameters["joint"] for f in findings if f.kind.name == "gain"),
    )


def _explains_errors(finding: Candidate, diagnostic: Diagnostic) -> bool:
    """Tell whether a finding may be why placements fitted alone leave much."""
    is_serious = diagnostic.level == "error" or diagnostic.advice.endswith(HELD_OUT)
    return is_serious or "frame" in finding.parameters or finding.kind.name in FITTED


def _unexplained(
    measured: Measurement, floor: float, noise: float, worst: int
) -> Diagnostic:
    text = (
        f"fitted alone it leaves {1e3 * floor:.2f} mm, more than {MANY:.0f} times the "
        f"{1e3 * noise:.2f} mm that are usual of this arm. No single cause explains it"
    )
    advice = "look at ball, sockets and base, and record it again; or give --repeatability-mm"
    if measured.kind == "points":
        number = int(measured.order[worst]) + 1
        advice = f"the worst is point {number}: are all of one target, in a right-handed frame?"
    level = "error" if floor > GARBAGE else "warning"
    return Diagnostic(level, "floor", where_of([measured]), text, advice)


def _diagnostic(
    finding: Candidate,
    measurements: Sequence[Measurement],
    given: Given,
    *,
    zeros: bool,
) -> Diagnostic:
    """Return a finding in words, and how much it matters."""
    told, kind, p = finding.hypothesis(), finding.kind, finding.parameters
    level, code, advice = kind.level, kind.code, told.advice
    held_out = (
        bool(given.trained)
        and p.get("placement", given.trained[0]) not in given.trained
    )
    weighed = kind in KINDS and told.name not in UNWEIGHED
    costs = consequence_of(finding, given.trained) if weighed and not held_out else None
    # nothing can be trusted where samples scatter that much, however little the fit heeds them
    scattered = p.get("noise_here", 0.0) >= MOST_NOISE
    if costs is not None and not scattered:
        level = level_of(costs, finding.scene.noise)
    if level == "error" and (_is_slight(finding, zeros=zeros) or _is_noise(finding)):
        level = "warning"
    if told.name == "ball_sample" and p["size"] > SEATED:
        code = "elsewhere"
        advice = (
            "it was recorded elsewhere, by another base or arm; solve leaves it out"
        )
        if finding.of_points:
            advice = "it is of another target, or of another pose; solve leaves it out"
    advice = _by_mender(advice, given)
    if (
        level == "error"
        and not zeros
        and p["noise"] > LOOSE
        and told.name not in NOT_PLAY
    ):
        advice += PLAY_HINT
    if held_out and told.name == "copies":
        level = "note"  # it proves nothing, as the errors held out say
    sound_enough = not (scattered or _is_garbage(finding))
    if held_out and (weighed or level == "error") and sound_enough:
        level, advice = "warning", f"{advice}{HELD_OUT}"
    return Diagnostic(
        level, code, _where(finding, measurements), told.text, advice, costs
    )


def _where(finding: Candidate, measurements: Sequence[Measurement]) -> str:
    """Return the sample, the placement or the known distance that a finding concerns."""
    p = finding.parameters
    if "known" in p:
        return f"--known {p['known']}"
    if finding.of_all:
        return where_of(measurements)
    measured = next(m for m in measurements if m.name == p["placement"])
    if "sample" in p and not p.get("throughout"):
        return row_of(measured, p["socket"], p["sample"])
    return where_of([measured])


def _is_slight(finding: Candidate, *, zeros: bool) -> bool:
    """Tell whether something else says how much a finding matters, or it is a small one.

    Of a distance, the size of the arm decides; of what is fitted, the errors.
    """
    name, p = finding.kind.name, finding.parameters
    if name == "gain":
        return abs(p["offset"]) < LEAST_GAIN
    if name in FITTED:
        return p["noise"] <= LOOSE
    smallest = {"base_moved": SMALLEST_MOVE, "drift": PLAY if zeros else MOST_DRIFT}
    return name == "distance" or p.get("size", 0.0) < smallest.get(name, 0.0)


def _by_mender(advice: str, given: Given) -> str:
    """Return advice by what sets recordings right: not every solve does."""
    return advice.replace(f"{MENDER} ", f"{given.mender} ", 1)


def _is_garbage(finding: Candidate) -> bool:
    """Tell whether a finding's placement, fitted alone, leaves a centimetre: held out, too."""
    scene = finding.scene
    # Beside a cause of all there is none.
    floors = zip(scene.measurements, scene.floors, strict=False)
    name = finding.parameters.get("placement")
    return any(floor > GARBAGE for m, floor in floors if m.name == name)


def _is_noise(finding: Candidate) -> bool:
    """Tell whether a finding is noise that a fit averages out, and far from the nominal errors."""
    if finding.kind.noise is None or finding.sigma >= MOST_NOISE:
        return False
    return (
        finding.kind.name != "unexplained"
        or finding.sigma < nominal_errors(finding.scene) / 2
    )


def next_placement(robot: Robot, survey: Survey) -> str:
    """Return in words which two placements to train on (paper, Fig. 6), and the next place."""
    mistaken = any(diagnostic.level == "error" for diagnostic in survey.shared)
    wrong = [one.measured.name for one in survey.placements if not one.sound]
    if mistaken and not wrong:
        return "First mend what all placements have: see the errors."
    words = [f"First mend {' and '.join(wrong)}: see the errors."] if wrong else []
    if mistaken:  # what all have may be of that alone
        return words[0]
    seated = [one for one in survey.placements if one.measured.kind == "sockets"]
    good = [one for one in seated if one.sound]
    if not seated:
        words.append(POINTS_HINT)
    if not good:
        return " ".join(words)
    centres = np.array([one.centre for one in good])
    if len(good) > 1:
        apart = np.linalg.norm(centres[:, None] - centres, axis=2)
        farthest = divmod(int(np.argmax(apart)), len(good))
        best = " and ".join(good[i].measured.name for i in farthest)
        words.append(f"To train on two, {best} serve best: they are the most distant.")
    place = farthest_place(centres)
    x, y, z = place.tolist()
    gap = float(np.linalg.norm(centres - place, axis=1).min())
    aside = y / float(np.hypot(x, y))
    side = "left" if aside > 0.1 else "right" if aside < -0.1 else "front"
    words.append(
        f"Another placement serves best near x {x:+.2f}, y {y:+.2f}, z {z:+.2f} m in the frame of "
        f"{robot.base} (to its {side}), {gap:.2f} m from the nearest so far, or as far that "
        "way as the arm reaches."
    )
    return " ".join(words)


def farthest_place(centres: np.ndarray) -> np.ndarray:
    """Return a place in front or beside, farthest from centres of shape (P, 3), shape (3,) [m]."""
    radius = np.linalg.norm(centres[:, :2], axis=1).mean()
    height = centres[:, 2].mean()
    angles = np.deg2rad(np.arange(-90, 91, 15))
    x, y = radius * np.cos(angles), radius * np.sin(angles)
    ring = np.column_stack([x, y, np.full(len(angles), height)])
    distances = np.linalg.norm(ring[:, None] - centres, axis=2)
    gaps = distances.min(axis=1)
    return ring[int(np.argmax(gaps))]
