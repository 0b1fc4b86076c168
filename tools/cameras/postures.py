"""Joint positions of views that name poses of the flange in their place.

Up to eight postures of an arm of six joints bring its flange to one pose. Nominally they are alike;
the calibrated arm errs otherwise in each. The views of a session stand in one posture, each next to
others, so the postures of all views follow from that of a single view. Which posture it was, all
views tell together, or a person. With the distances d_i and angles a_i that camera and board leave,
and s the scales of those in the best posture, the evidence of a posture is that of Student's t:

    ln L = -(n + 3)/2 sum_i [ ln(1 + d_i^2 / (n s_d^2)) + ln(1 + a_i^2 / (n s_a^2)) ]
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...recorder import Placement, around
from ...solver.calibration import Calibration, UsageError, pose_of_numbers
from ...solver.identification.data import FrameError, HandEye, hand_eye
from ...solver.identification.robot import workspace
from ...solver.partial import LEAST_ANGLE, LEAST_PLACE, SURE, Camera
from .spanning_tree import spanning_tree

COLUMNS = tuple(f"flange_{name}" for name in ("x", "y", "z", "qx", "qy", "qz", "qw"))
"""Columns that stand in place of the joints: the flange in the base [m]."""
STARTS = 60
"""Postures from which each pose is sought."""
REACHED, SAME = 1e-4, 1e-2
"""Most that a pose leaves [m], [rad]; joints of one solution differ by less [rad]."""
APART = 0.5
"""A posture that is no farther than this beyond the nearest one leaves the choice open [rad]."""
FREEDOM = 4.0
"""Degrees of freedom n of Student's distribution: a view in ten may be an outlier."""
MEDIAN = 1.54
"""Median length of a vector of three normal errors of unit deviation."""
HALF_TURN = np.diag([-1.0, -1, 1, 1])
"""Turn from a UR's link `base` to its `base_link`, about their common z axis."""
NEAR, MUCH_NEARER = 0.3, 0.5
"""Distance of the nearest view from the posture up to which poses are not tried half a turn on
[rad], and the factor by which either must be nearer."""


@dataclass(frozen=True)
class Session:
    """Joint positions of all views, in one of the arm's postures."""

    positions: np.ndarray
    """Shape (N, m) [rad]."""
    distance: float
    """Root mean square distance of the views from the posture that was told, 0 for none [rad]."""
    nearest: float
    """Distance of the nearest view [rad]."""
    fit: HandEye | None
    """Errors that the views leave by the calibrated arm; None where they do not tell."""

    @property
    def scales(self) -> np.ndarray:
        """Standard deviations an axis of the distances [m] and angles [rad] that are left."""
        if not self.fit:
            return np.ones(2)
        errors = [self.fit.distances, self.fit.angles]
        return np.maximum(
            np.median(errors, axis=1) / MEDIAN, [LEAST_PLACE, LEAST_ANGLE]
        )

    def evidence(self, scales: np.ndarray) -> float:
        """Return ln L, by the scales of the best posture."""
        if not self.fit:
            return 0.0
        errors = np.array([self.fit.distances, self.fit.angles])
        pulls = errors / scales[:, None]
        power = (FREEDOM + 3) / 2
        return float(-power * np.sum(np.log1p(pulls**2 / FREEDOM)))

    def mostly(self, session: "Session") -> bool:
        """Return whether most views stand in another session as they do in this one."""
        differences = np.abs(self.positions - session.positions)
        alike: np.ndarray = differences.max(axis=1) < SAME
        return float(np.mean(alike)) > 0.5

    def __str__(self) -> str:
        """Errors that the views leave, in words."""
        distance, angle = (1e3 * self.scales).tolist()
        return f"{distance:.2f} mm and {angle:.2f} mrad an axis"


@dataclass(frozen=True)
class FlangePoses:
    """Views that name poses of the flange, and the arm that stood there."""

    calibration: Calibration
    views: Placement
    near: np.ndarray | None
    """A posture near which the joints stood, shape (m,) [rad]."""
    camera: Camera | None
    """Place of the camera, for the views to tell the posture; None to do without."""

    @property
    def where(self) -> str:
        """The file, for messages."""
        return str(self.views.first_file)

    @property
    def turning(self) -> list[bool]:
        """True for each joint that turns."""
        return [joint.type != "prismatic" for joint in self.calibration.robot.actuated]

    def sessions(self, poses: np.ndarray) -> list[Session]:
        """Return the postures in which a session may bring the flange to poses, shape (N, 4, 4)."""
        postures = _postures(self._solutions(poses), self.turning)
        return [self._session(q) for q in postures]

    def _solutions(self, poses: np.ndarray) -> list[np.ndarray]:
        """Return the joint positions that bring the flange to each pose, up to whole turns."""
        starts = workspace(self.calibration.robot, len(poses) * STARTS)
        goal, targets = self.calibration.goal(np.repeat(poses, STARTS, axis=0))
        nominal = self.calibration.nominal.calibrated
        search = nominal.search(goal, targets, starts, None, np.eye(4))
        reached = search.left.max(axis=1) < REACHED
        solutions: list[np.ndarray] = []
        for i, sample in enumerate(self.views.samples):
            rows = slice(i * STARTS, (i + 1) * STARTS)
            distinct = _distinct(search.positions[rows][reached[rows]], self.turning)
            if not distinct:
                where = sample.where or f"view {i}"
                raise UsageError(
                    f"{where}: no posture within the limits brings the flange there"
                )
            solutions.append(np.array(distinct))
        return solutions

    def _session(self, q: np.ndarray) -> Session:
        """Return a posture, beside the one that was told and by what the views leave."""
        robot = self.calibration.robot
        reference = np.zeros(q.shape[1])
        if self.near is not None:
            reference = self.near
        away = around(q - reference, self.turning)
        on_turn = reference + away
        within = (robot.lower <= on_turn) & (on_turn <= robot.upper)
        positions = np.where(within, on_turn, q)
        if self.near is None:
            return Session(positions, 0.0, 0.0, self._fit(q))
        distances: np.ndarray = np.linalg.norm(away, axis=1)
        distance = float(np.sqrt(np.mean(distances**2)))
        return Session(positions, distance, float(distances.min()), self._fit(q))

    def _fit(self, q: np.ndarray) -> HandEye | None:
        """Return camera and board by the calibrated arm, and what they leave of the views."""
        if self.camera is None:
            return None
        rows: list[tuple[float, ...]] = []
        for sample in self.views.samples:
            if sample.orientation is None or sample.point is None:
                return None
            rows.append((*sample.point, *sample.orientation))
        B = pose_of_numbers(rows)
        M = np.linalg.inv(B) if self.camera == "on-arm" else B
        F = self.calibration.flange(q)
        R = F[:, :3, :3]
        p = F[:, :3, 3]
        try:
            return hand_eye(R, p, M[:, :3, :3], M[:, :3, 3])
        except FrameError:
            return None


def names_flange_poses(views: Placement) -> bool:
    """Return whether the columns of views are :data:`COLUMNS`."""
    return set(views.joint_names or ()) == set(COLUMNS)


def flange_poses(views: Placement) -> np.ndarray:
    """Return the flange's poses in the columns of views, shape (N, 4, 4)."""
    names = views.joint_names or ()
    order = [names.index(name) for name in COLUMNS]
    return pose_of_numbers(views.positions[:, order])


def joints_of(
    calibration: Calibration,
    views: Placement,
    near: Sequence[float] | None,
    camera: Camera | None = None,
) -> Placement:
    """Return views whose columns are :data:`COLUMNS` with joint positions in place of these poses.

    Args:
        calibration: The calibrated arm; poses are those of its nominal model.
        views: The views.
        near: A posture near which the joints stood, shape (m,) [rad]; None for the views to tell.
        camera: Where the camera is; None for views that cannot tell the posture.

    Raises:
        UsageError: Several postures, endlessly many or none bring the flange to a pose, or the
            posture does not tell whether the poses are half a turn off.
    """
    if not names_flange_poses(views):
        return views
    posture = None if near is None else np.array(near)
    flange = FlangePoses(calibration, views, posture, camera)
    robot = calibration.robot
    where = flange.where
    if (m := len(robot.joint_names)) > 6:
        raise UsageError(
            f"{where}: {m} joints bring a flange to one pose in endlessly many ways; record the "
            f"joints ({', '.join(robot.joint_names)}) in place of {COLUMNS[0]}, .."
        )
    poses = flange_poses(views)
    flange_link = robot.ball_joint.parent
    remarks = [
        f"{where}: joints recovered from the flange's poses by the nominal model",
        f"{where}: taken as poses of {flange_link}; if a tool is set in the controller, they are "
        "the tool's: take its offset off first",
    ]
    sessions = flange.sessions(poses)
    nearest = min(session.nearest for session in sessions)
    if nearest > NEAR:
        turned = flange.sessions(HALF_TURN @ poses)
        nearest_turned = min(session.nearest for session in turned)
        if nearest_turned < MUCH_NEARER * nearest:
            sessions = turned
            remarks.append(
                f"{where}: the poses are half a turn about z off {robot.base}, as in the frame "
                f"`base` of a UR's controller: they were turned into {robot.base}"
            )
        elif nearest > MUCH_NEARER * nearest_turned:
            raise UsageError(
                f"{where}: --near is {nearest:.1f} rad from the nearest view. It is "
                f"{nearest_turned:.1f} rad off if the poses are half a turn about z off "
                f"{robot.base}, as in a UR's frame `base`. Give the joints of one of the views"
            )
    session, notes = _chosen(sessions, flange)
    texts = (*views.remarks, *remarks, *notes)
    views = views.with_positions(session.positions)
    return replace(views, joint_names=robot.joint_names, remarks=texts)


def _chosen(
    sessions: Sequence[Session],
    flange: FlangePoses,
) -> tuple[Session, list[str]]:
    """Return the session's posture: the nearest, and of several as near, what the views tell."""
    nearest = min(session.distance for session in sessions)
    scales = np.min([session.scales for session in sessions], axis=0)
    ranked = sorted(sessions, key=lambda session: -session.evidence(scales))
    session, *rivals = [
        candidate for candidate in ranked if candidate.distance <= nearest + APART
    ]
    rivals = [rival for rival in rivals if not rival.mostly(session)]
    if rivals and session.evidence(scales) - rivals[0].evidence(scales) < SURE:
        advice = "give one near which all views were taken (--near)"
        if flange.near is not None:
            advice = "several as near; record the joints"
        raise UsageError(
            f"{flange.where}: {len(rivals) + 1} postures bring the flange there, and the views do "
            f"not tell which: {advice}"
        )
    if rivals:
        words = f"{len(rivals) + 1} postures bring the flange there; the views leave {session} in "
        return session, [
            f"{flange.where}: {words}this posture, {rivals[0]} in the next"
        ]
    if ranked[0].evidence(scales) - session.evidence(scales) < SURE:
        return session, []
    words = f"the posture near --near leaves {session} of the views, another one {ranked[0]}"
    return session, [f"{flange.where}: {words}; is the calibration this arm's?"]


def _distinct(
    postures: Iterable[np.ndarray],
    turning: list[bool],
) -> list[np.ndarray]:
    """Return each of some joint positions, shape (..., m) each, once, up to whole turns."""
    distinct: list[np.ndarray] = []
    for q in postures:
        differences = [around(q - other, turning) for other in distinct]
        distances = [np.abs(difference).max() for difference in differences]
        if all(distance > SAME for distance in distances):
            distinct.append(q)
    return distinct


def _postures(
    solutions: list[np.ndarray],
    turning: list[bool],
) -> list[np.ndarray]:
    """Return the joint positions of all views in each posture, shape (N, m) each.

    From each solution of the view that has most, the nearest solution of another view is added,
    and so on (a spanning tree): neighbours among views stand alike, however far the views go.
    """
    counts = [len(rows) for rows in solutions]
    view = np.repeat(np.arange(len(counts)), counts)
    q = np.concatenate(solutions)
    differences = around(q[:, None] - q, turning)
    distances = np.linalg.norm(differences, axis=2)
    postures: list[np.ndarray] = []
    for root in np.flatnonzero(view == np.argmax(counts)).tolist():
        nodes = [root, *(node for node, _ in spanning_tree(distances, root, view))]
        postures.append(q[sorted(nodes)])
    return _distinct(postures, turning)
