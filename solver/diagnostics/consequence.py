"""Consequences of explanations: what distances are with one and without it, by one linear system.

Both models are fitted to the same samples, whose weights are robust.
"""

from collections.abc import Collection, Sequence
from functools import cached_property
from itertools import chain

import numpy as np

from ..results import Consequence
from ..robot import workspace
from .hypotheses import INDEPENDENT, Candidate, Scene, robust_weights, typical

POSES, PAIRS, ROUNDS = 200, 400, 5
"""Random poses of the workspace, pairs of poses, and rounds of the robust fits."""
PREDICTED_MARGIN, LARGEST_PREDICTED = 3.0, 2e-3
"""The predicted error of distances may be this many times the limit on held-out errors, but no more
than so much [m], or that limit: good recordings of arms that repeat to 0.1 mm come to 1 to 2.4."""
MARGIN = 3.0
"""Limit on held-out errors, in repeatabilities."""
SEVERE, SLIGHT = 1 / 3, 1 / 10
"""Shares of the limit above which a consequence is an error, and below which it is a note."""
SHIFTED = ("zero", "gain")
"""Causes by which a joint reads something else in all poses."""
OF_GEOMETRY = ("length", "angle", "version")
"""Causes in the numbers of the URDF."""


def predicted_limit(limit: float) -> float:
    """Return what predicted errors of distances may come to [m], by the limit on held-out ones."""
    return max(limit, min(PREDICTED_MARGIN * limit, LARGEST_PREDICTED))


def level_of(consequence: Consequence, noise: float) -> str:
    """Return how much a consequence matters, by what an arm repeats [m].

    ``error``: the model could be worse than the nominal one by it, or it is more than a third of
    the limit on predicted errors of distances. ``note``: it is below a tenth of that limit.
    """
    change = consequence
    share = max(change.near, change.workspace) / predicted_limit(MARGIN * noise)
    if share <= SLIGHT:
        return "note"
    worse = (
        change.near > change.near_before or change.workspace > change.workspace_before
    )
    return "error" if worse or share > SEVERE else "warning"


def consequence_of(
    finding: Candidate, training: Collection[str] = ()
) -> Consequence | None:
    """Return what an explanation does to distances near the recorded places and elsewhere.

    The model is of the placements in ``training``; of all if none is named. None: the explanation
    is noise, which is part of what is known of any model.
    """
    scene = finding.scene
    if finding.kind.noise is not None:
        return None
    names = [m.name for m in scene.measurements]
    counted = [p for p, name in enumerate(names) if not training or name in training]
    plain_fit, fit = _Fit(scene, counted), _Fit(finding.after(), counted)
    shifts: list[float] = []
    before: list[float] = []
    for q in (
        workspace(scene.robot, POSES),
        *(scene.q[scene.places[p]] for p in counted),
    ):
        points = plain_fit.points(q)
        shifts.append(spread(fit.points(q, finding) - points))
        before.append(spread(points - plain_fit.nominal_points(q)))
    place = 1 + int(np.argmax(shifts[1:]))
    return Consequence(shifts[place], shifts[0], before[place], before[0])


def nominal_errors(scene: Scene) -> float:
    """Return the errors of distances by the nominal model near the recorded places [m]."""
    fit = _Fit(scene, range(len(scene.places)))
    sizes: list[float] = []
    for rows in scene.places:
        q = scene.q[rows]
        sizes.append(spread(fit.points(q) - fit.nominal_points(q)))
    return max(sizes)


def spread(shifts: np.ndarray) -> float:
    """Return how much distances between places change that shift so, shape (N, 3) [m].

    The distance of two places changes by the difference of their shifts along one direction: by
    |d_i - d_j| / sqrt(3), of which this is the median over random pairs.
    """
    generator = np.random.default_rng(0)
    first, second = generator.integers(len(shifts), size=(2, PAIRS))
    distances = np.linalg.norm(shifts[first] - shifts[second], axis=1)
    between_two = distances[first != second]
    return float(np.median(between_two)) / 3**0.5


class _Fit:
    """A robust fit to a scene, linear in all unknowns."""

    def __init__(self, scene: Scene, counted: Sequence[int]) -> None:
        """Fit the placements of some indices."""
        self.scene = scene
        rows, samples = _rows_of(scene, counted)
        B, r = scene.nuisances[rows], scene.residuals[rows]
        weights, x = np.ones(len(r)), np.zeros(B.shape[1])
        for _ in range(ROUNDS):
            errors = (r - B @ x)[:samples].reshape(-1, 3)
            noise = float(typical(errors))
            weights[:samples] = np.repeat(robust_weights(errors, noise), 3)
            across = (B * weights[:, None]).T
            precision = noise**2 / INDEPENDENT * np.eye(len(x))
            x = np.linalg.solve(across @ B + precision, across @ r)
        self._x = x

    @cached_property
    def unknowns(self) -> np.ndarray:
        """Geometry and effects of the arm, shape (size,)."""
        scene = self.scene
        widths = scene.widths_of_effects(scene.as_readings)
        sizes = [scene.centres.size, len(scene.parameters), len(widths)]
        _, of_geometry, of_effects, _ = np.split(self._x, np.cumsum(sizes))
        return np.concatenate([scene.usual @ of_geometry, widths * of_effects])

    def points(self, q: np.ndarray, finding: Candidate | None = None) -> np.ndarray:
        """Return the ball's places as the fit has them, with an explanation of the arm if any."""
        unknowns, true = self.unknowns.copy(), q.copy()
        name = "" if finding is None else finding.kind.name
        if finding is None or name not in SHIFTED + OF_GEOMETRY:
            return self._predict(unknowns, true)
        block, scene = finding.block, self.scene
        values = max(block.widths) * self._x[-block.unknowns :]
        if name in OF_GEOMETRY:
            columns: np.ndarray = scene.by_geometry @ scene.usual
            shift: np.ndarray = block.columns[0] @ values
            change = scene.usual @ np.linalg.pinv(columns, rcond=1e-6) @ shift
            unknowns[: len(change)] += change
        else:
            joint = scene.robot.joint_names.index(block.parameters[0]["joint"])
            true[:, joint] += values[0] * (q[:, joint] if name == "gain" else 1.0)
        return self._predict(unknowns, true)

    def nominal_points(self, q: np.ndarray) -> np.ndarray:
        """Return the ball's places as the nominal model has them, with the ball of the fit."""
        unknowns = np.zeros_like(self.unknowns)
        of_ball = [i for i, p in enumerate(self.scene.parameters) if p.of_ball]
        unknowns[of_ball] = self.unknowns[of_ball]
        return self._predict(unknowns, q)

    def _predict(self, unknowns: np.ndarray, q: np.ndarray) -> np.ndarray:
        moments = self.scene.load.moments(self.scene.heavy, q, None)
        return self.scene.model.predict(unknowns, q, moments)


def _rows_of(scene: Scene, counted: Sequence[int]) -> tuple[list[int], int]:
    """Return the rows of some placements' samples, then of distances between these; and how many.

    The number is that of the rows of samples.
    """
    every = range(scene.all_lengths.stop)
    rows = [*chain.from_iterable(every[scene.rows(scene.places[p])] for p in counted)]
    names = {scene.measurements[p].name for p in counted}
    lengths: list[int] = []
    for row, length in enumerate(scene.known, scene.all_lengths.start):
        if {scene.labels[length.first][0], scene.labels[length.second][0]} <= names:
            lengths.append(row)
    return rows + lengths, len(rows)
