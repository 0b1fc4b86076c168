"""Recordings about a robust fit, as a linear scene, and the errors of fits to single placements."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...errors import MukcaError
from ..identification.data import (
    CALIPER_DEVIATION,
    STANDARD_LOAD,
    KnownDistance,
    Load,
    Measurement,
    is_called,
    places_of,
)
from ..identification.robot import Robot
from .hypotheses import FLAWS, Scene, evenly, medians, samples_of
from .robust_fit import ABOUT, FEW, UNEXPLAINED, RigidModel

MOST = 240
"""Samples of a placement that are used at most, evenly chosen."""
USUAL = 2e-4
"""Prior noise of an arm of unknown repeatability [m]."""
USUAL_WIDTH = 0.6
"""Standard deviation of its logarithm."""
KNOWN_WIDTH = 0.25
"""The same where the repeatability is known."""
INSTRUMENTS = 1.0
"""The same of the noise of points: trackers measure to 0.02 mm, cameras to a millimetre."""
SERVOS = 4e-4
"""Noise of arms made of servos apart from the play of their gears [m]."""
RESOLUTION = 1e-4
"""Repeatability that a printed socket shows at best [m]."""
BAD_RATIO = 2.5
"""Factor on the usual error of the other placements, beyond which one stands out."""
EXACT = 1e-5
"""Largest error of a fit to fewer samples than unknowns [m], which means nothing."""
MENDER = "solve"
"""The verb that sets recordings right unless told otherwise, as the texts of causes have it."""


@dataclass(frozen=True)
class Given:
    """Settings of an inspection: known distances and the load."""

    known: Sequence[KnownDistance] = ()
    """Distances measured beside those between each placement's sockets."""
    deviation: float = CALIPER_DEVIATION
    """Standard deviation of the latter [m]."""
    load: Load = STANDARD_LOAD
    """Gravity and payload."""
    mender: str = MENDER
    """The verb that sets recordings right, in the words of advice."""
    trained: Sequence[str] = ()
    """Names of the placements to train on; none where all may be. What is wrong in others does
    nothing to the model."""
    weighs: bool = False
    """True where the fit has unknowns for what differs between places."""

    def within(self, measurements: Sequence[Measurement]) -> "Given":
        """Return it with the distances between sockets of some placements alone."""
        names = [m.name for m in measurements]

        def is_within(end: tuple[str, int]) -> bool:
            return any(is_called(name, end[0]) for name in names)

        known = [k for k in self.known if is_within(k.first) and is_within(k.second)]
        return replace(self, known=known)


def scene_of(
    model: RigidModel,
    measurements: Sequence[Measurement],
    given: Given,
    repeatability: float | None,
    floors: Sequence[float] | None = None,
    start: np.ndarray | None = None,
) -> Scene:
    """Return recordings as a linear model about a robust fit, begun at some unknowns.

    ``floors`` are the errors of fits to each placement alone [m]; None to fit them.

    Raises:
        KnownError: A known distance names a socket that is not there.
    """
    places = places_of(
        measurements,
        lengths=given.known,
        deviation=given.deviation,
        require_scale=False,
    )
    if floors is None:
        floors = list(fitted_alone(model.robot, measurements).values())
    thin, numbers = zip(*map(_thinned, measurements), strict=True)
    pairs = zip(thin, standing_out(floors), strict=True)
    sound = [measured for measured, usual in pairs if usual is None]
    fit = model.fit(samples_of(sound or thin).thinned(ABOUT, FEW), start=start)
    centres, turns = fit.centres, fit.R
    if len(sound) < len(thin):
        samples = samples_of(thin)
        balls = model.points(fit.x, samples.q)
        turns = samples.robustly_aligned(balls)
        centres = medians(balls - samples.offsets(turns), samples)
    noise = SERVOS
    if not model.zeros:
        noise = max(RESOLUTION, repeatability or USUAL)
    return Scene(
        robot=model.robot,
        parameters=model.parameters,
        measurements=thin,
        known=tuple(length for length in places.known if length.distance),
        x=fit.x,
        by_scale=model.by_scale,
        centres=centres,
        R=turns,
        floors=tuple(floors),
        noise=noise,
        noise_width=_noise_width(model, measurements, repeatability),
        load=given.load,
        zeros=model.zeros,
        numbers=np.concatenate(numbers),
    )


def _noise_width(
    model: RigidModel,
    measurements: Sequence[Measurement],
    repeatability: float | None,
) -> float:
    """Return the standard deviation of the logarithm of the noise that is expected."""
    if any(m.kind == "points" for m in measurements):
        return INSTRUMENTS
    is_unknown = model.zeros or repeatability is None
    return USUAL_WIDTH if is_unknown else KNOWN_WIDTH


def _thinned(measured: Measurement) -> tuple[Measurement, np.ndarray]:
    """Return a placement with so many samples of each socket at most, evenly chosen.

    And the number of each sample in its socket as it was, from 0.
    """
    limit = max(MOST // len(measured.counts), 2)
    numbers = [evenly(count, limit) for count in measured.counts]
    pairs = zip(measured.slices, numbers, strict=True)
    ranks = np.concatenate([measured.order[rows][chosen] for rows, chosen in pairs])
    return measured.only(np.sort(ranks)), np.concatenate(numbers)


def fitted_alone(
    robot: Robot,
    measurements: Sequence[Measurement],
) -> dict[str, float]:
    """Return the error that a robust rigid fit to each placement alone leaves, by its name [m].

    It is the mean distance of its samples from their socket, each by its weight.
    """
    model = RigidModel(robot)
    return {m.name: model.fit(samples_of([m])).error for m in measurements}


def standing_out(floors: Sequence[float]) -> list[float | None]:
    """Return the error that a placement should leave by the others', if it stands out, else None.

    ``floors`` are the errors that each placement leaves when fitted alone [m].
    """
    outliers: list[float | None] = []
    for i, floor in enumerate(floors):
        others = [*floors[:i], *floors[i + 1 :]]
        usual = float(np.median(others)) if others else np.inf
        if len(others) == 1:
            usual = max(usual, UNEXPLAINED / BAD_RATIO)
        largest = BAD_RATIO * max(usual, EXACT)
        stands_out = usual < UNEXPLAINED and floor > largest
        outliers.append(usual if stands_out else None)
    return outliers


class FlawError(MukcaError):
    """The recordings can have no such flaw."""


def shift_by(
    robot: Robot,
    measured: Measurement,
    flaw: str,
    size: float,
    generator: np.random.Generator,
) -> np.ndarray:
    """Return by how much a flaw moves the balls as they were recorded, shape (N, 3) [m].

    Of several joints it takes one amid the chain; what is free besides is random.

    Args:
        robot: The robot that recorded.
        measured: Its recording.
        flaw: A word of :data:`.FLAWS`.
        size: How large the flaw is [m, rad, share]: at the ball at most, or its unknowns.
        generator: Source of what is free.

    Raises:
        FlawError: The recordings can have no such flaw.
    """
    scene = scene_of(RigidModel(robot), [measured], Given(), None)
    for kind in FLAWS[flaw]:
        for block in kind.blocks(scene):
            amid = block.columns[len(block.parameters) // 2]
            direction = generator.normal(size=block.unknowns)
            change = amid @ (direction / np.linalg.norm(direction))
            shifts = scene.in_rows(block.rows, change)[scene.all_samples].reshape(-1, 3)
            largest = float(np.linalg.norm(shifts, axis=1).max())
            shifts = size / (largest if kind.at_ball else 1.0) * shifts
            return measured.as_recorded(shifts)
    raise FlawError(f"fault {flaw!r}: these recordings can have none")
