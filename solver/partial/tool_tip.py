"""A tool's tip on the flange, by points that it touched, the calibrated chain held."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations, compress

import numpy as np

from ...recorder import Placement
from ..calibration import Calibration, UsageError, as_list
from ..identification.data import Measurement, Pose, measure, one_blas_thread
from ..poses import InverseKinematics, SimulationError
from .doubts import ChangedZeros, changed_zeros
from .fit import fit
from .prior import ArmPrior, prior_of
from .sockets import socket_task
from .task import FAR, NoiseBelief, Task
from .updated import LIMIT, Found, found, not_enough, signed

TOUCH, SPREAD = 1e-4, 1.0
"""Noise of touching a point [m], and the standard deviation of its logarithm."""
LEAST, LEAST_EACH = 4, 3
"""Touches that a tip needs, and of each point."""
LEAST_APART = 2e-3
"""Least distance of points of the tool that define a direction [m]."""
LOOSE = 2e-3
"""Scatter of touches beyond which the tip is not to be relied on [m]."""
SCATTER = (
    "Touches scatter by {:.1f} mm: did the point give way, are they several points, or is it "
    "another arm's calibration?"
)
WHOSE_FLANGE = (
    "That is the flange of this calibration, which may be a millimetre and more from the metal: "
    "use the tip with this calibration alone."
)
"""The ball's place is all that a calibration saw; the flange follows from the nominal model."""
ELSEWHERE, POSTURES = 6, 8
"""Points elsewhere at which the tip's spread is predicted, and postures at each."""
NEAR, FAR_OUT, HIGH = 0.35, 0.65, 0.25
"""Distance of these from the base's axis, and height, as shares of the reach: where arms work."""


@dataclass(frozen=True, repr=False)
class Tool(Found):
    """A tool on the flange, estimated with the calibrated chain held."""

    noise: float
    """Of touching a point, a standard deviation per axis [m]."""
    elsewhere: float | None
    """Predicted scatter of the tip about a point that it touches elsewhere, a root mean square [m];
    None where no such postures were found."""
    residuals: np.ndarray
    """Distance that each touch leaves to its point, shape (N,) [m]."""
    outliers: tuple[str, ...] = ()
    """Outliers among the touches, in words."""

    @property
    def brief(self) -> tuple[str, ...]:
        """The tip and what it is good for, line by line; reasons not to rely on it come first."""
        place = f"{self.frame.name} on {self.frame.parent}: {self.place}"
        lines = [*self.untold, place, WHOSE_FLANGE]
        if any(self.frame.rpy):
            angles = signed(self.frame.rpy, 5)
            lines.append(f"roll pitch yaw {angles} rad")
        if self.elsewhere is not None:
            lines.append(
                f"Turned about a point elsewhere, the tip is expected to stay within "
                f"{1e3 * self.elsewhere:.2f} mm of it (1 sigma)."
            )
        return (*lines, *self.notes, *self.outliers)

    @property
    def scatter(self) -> str:
        """Scatter of the touches, in words."""
        return f"Touches scatter by {1e3 * self.noise:.3f} mm an axis."


@one_blas_thread
def tool(
    calibration: Calibration,
    data: Placement | Sequence[Placement],
    name: str = "tool",
    *,
    axis: Placement | Sequence[Placement] = (),
    face: tuple[Placement, Placement] | None = None,
    stood: str = "",
    limit: float = LIMIT,
) -> Tool:
    """Find where a tool's tip is on the flange, by points that it touched.

    Args:
        calibration: The calibration; the arm is held as it left it, within its covariance.
        data: Touches of fixed points, each a socket of a placement: 4 or more of a point, the tool
            turned as far as it goes between them. Samples that hold a point say where it is in a
            frame of their own. The ball is no longer on the flange.
        name: Of the tool's link in the URDF.
        axis: Touches by a second point of the tool, up its shaft: the link's z points from there to
            the tip.
        face: Touches by two more points of a flat tool, in place of ``axis``: z is normal to the
            three, away from the flange, and x points to the first of the two.
        stood: Placement of the calibration whose sockets, which stand where they stood, it touched.
        limit: Standard deviation in any direction, above which the touches are not enough [m].

    Raises:
        UsageError: Too few touches, no such placement, or a calibration that leaves no posterior.
        ModelError: The model already has a link of that name.
        MeasurementError: Samples of another arm.
    """
    prior = prior_of(calibration)
    touches = as_list(data)
    system = fit(_touches(prior, touches, stood))
    tip = system.tool.translation
    zeros = changed_zeros(system, prior.ball)
    noise = system.state.noise.place
    doubts = zeros.rival(system) or _doubts(noise, zeros, limit)
    others = [as_list(axis)] if axis else [[further] for further in face or ()]
    further_fits = [fit(_touches(prior, group)) for group in others]
    R = _turned(tip, [further.tool.translation for further in further_fits])
    link = (name, prior.robot.ball_joint.parent)
    untold = _warnings_of_training(calibration, touches) + doubts
    frame = found(calibration, system, link, Pose(R, tip), zeros, untold)
    of_model = slice(prior.model.size)
    P = system.posterior_covariance(of_model)
    residuals = np.linalg.norm(system.residuals, axis=1)
    return Tool(
        **vars(frame),
        noise=noise,
        elsewhere=_elsewhere(prior, system.state.x[of_model], P),
        residuals=residuals,
        outliers=_outliers(system.outliers("touch"), residuals),
    )


def _doubts(scatter: float, zeros: ChangedZeros, limit: float) -> tuple[str, ...]:
    """Return a reason not to rely on a tip whose touches scatter by so much [m]; or none."""
    if scatter > LOOSE:
        return (SCATTER.format(1e3 * scatter),)
    return not_enough(
        zeros.covariance,
        limit,
        "touches cannot show the tip",
        "turn the tool about two more axes at the point",
    )


def _outliers(wheres: Mapping[int, str], distances: np.ndarray) -> tuple[str, ...]:
    """Return the outliers among the touches, in words, by their distances to the point [m]."""
    return tuple(
        f"{where}: {1e3 * distances[i]:.1f} mm from the point that the others touched; it has "
        "little weight."
        for i, where in wheres.items()
    )


def _warnings_of_training(
    calibration: Calibration, touches: Sequence[Placement]
) -> tuple[str, ...]:
    """Return a warning where touches are samples of the calibration itself, else nothing."""
    measured = _measured(calibration, touches)
    names = ", ".join(m.name for m in measured if calibration.was_trained_on(m))
    if not names:
        return ()
    return (
        f"{names}: the calibration was trained on these samples, so the tip is its ball, and they "
        "count twice: record touches of the tool.",
    )


def _touches(prior: ArmPrior, placements: Sequence[Placement], stood: str = "") -> Task:
    """Return the task of a fit to a tip's touches."""
    data = _measured(prior, placements)
    counts = [*chain.from_iterable(m.counts for m in data)]
    if sum(counts) < LEAST or min(counts, default=0) < LEAST_EACH:
        names = ", ".join(m.name for m in data)
        raise UsageError(
            f"{names}: {' + '.join(map(str, counts))} touches; a tip needs {LEAST} or more in "
            f"all, and {LEAST_EACH} or more of each point; 8 are advised"
        )
    task = socket_task(prior, data, stood)
    measured = [m.distance_source != "default" for m in data if m.has_distance]
    distances = [*compress(task.distances, measured)]
    first = 0
    for m, placement in zip(data, placements, strict=True):
        points = enumerate(_points_of(placement), first)
        for (i, a), (j, b) in combinations(points, 2):
            distances.append((i, j, math.dist(a, b)))
        first += len(m.sockets)
    noise = NoiseBelief(TOUCH, joint=prior.noise.joint, spread=SPREAD)
    widths = dict.fromkeys(prior.ball, FAR)
    return replace(task, free=widths, noise=noise, distances=distances)


def _points_of(placement: Placement) -> tuple[tuple[float, float, float], ...]:
    """Return the coordinates of the points that were touched [m]; none where they are not known."""
    return tuple(
        dict.fromkeys([sample.point for sample in placement.samples if sample.point])
    )


def _measured(
    arm: ArmPrior | Calibration, placements: Sequence[Placement]
) -> list[Measurement]:
    """Return checked touches; of points whose coordinates are known each is a socket."""
    data: list[Measurement] = []
    for placement in placements:
        points, samples = _points_of(placement), placement.samples
        if points:
            samples = [
                replace(s, point=None, socket=points.index(s.point))
                for s in samples
                if s.point
            ]
        touches = replace(placement, samples=tuple(samples))
        data.append(measure(touches, arm.robot, sockets=1))
    return data


def _turned(tip: np.ndarray, directions: Sequence[np.ndarray]) -> np.ndarray:
    """Return the tool's rotation by further points of it, the flange's own without any."""
    if not directions:
        return np.eye(3)
    x = directions[0] - tip
    if len(directions) == 1:
        z, least = -x, LEAST_APART
        x = np.eye(3)[np.argmin(np.abs(z))]
    else:
        z, least = np.cross(x, directions[1] - tip), LEAST_APART**2
        z = z * (np.sign(z @ tip) or 1.0)
    length = np.linalg.norm(z)
    if length < least:
        raise UsageError(
            f"the tool's points lie within {1e3 * LEAST_APART:g} mm of one point or line, which "
            "tells no direction; touch with points that are farther apart"
        )
    z = z / length
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _elsewhere(prior: ArmPrior, x: np.ndarray, P: np.ndarray) -> float | None:
    """Return the predicted scatter of the tip about points that it touches elsewhere [m].

    By the model's unknowns x and their covariance P.
    """
    model = prior.model
    robot = prior.robot.with_origins(model.ball.origins(model.values(x)))
    guide = InverseKinematics(robot)
    generator = np.random.default_rng(0)
    lowest, highest = (NEAR, -2.0, 0.0), (FAR_OUT, 2.0, HIGH)
    squares: list[float] = []
    for _ in range(10 * ELSEWHERE):
        radius, angle, height = generator.uniform(lowest, highest)
        point = [radius * np.cos(angle), radius * np.sin(angle), height]
        targets = np.tile(guide.longest * np.array(point), (POSTURES, 1))
        try:
            q = guide.reach(targets, generator, rounds=1)
        except SimulationError:
            continue
        slopes = model.linearise(x, prior.load.at(prior.robot, q))[1]
        differences = slopes - slopes.mean(axis=0)
        squares.append(float(np.sum(differences @ P * differences)) / POSTURES)
        if len(squares) == ELSEWHERE:
            break
    return float(np.mean(squares)) ** 0.5 if squares else None
