"""Consequences of explanations: what distances are with one and without it, by one linear system.

Both models are fitted to the same samples, whose weights are robust.
"""

from collections.abc import Collection, Sequence
from functools import cached_property
from itertools import chain

import numpy as np

from ..identification.robot import workspace
from ..results import Consequence
from .hypotheses import INDEPENDENT, Candidate, Scene, robust_weights, typical

POSES = 200
"""Random poses of the workspace."""
PAIRS = 400
"""Pairs of poses."""
ROUNDS = 5
"""Rounds of the robust fits."""
PREDICTED_MARGIN = 3.0
"""The predicted error of distances may be this many times the limit on held-out errors."""
LARGEST_PREDICTED = 2e-3
"""But it may be no more than this, or that limit [m]: good recordings of arms that repeat to 0.1 mm
come to 1 to 2.4 mm."""
MARGIN = 3.0
"""Limit on held-out errors, in repeatabilities."""
SEVERE = 1 / 3
"""Share of the limit above which a consequence is an error."""
SLIGHT = 1 / 10
"""Share of the limit below which it is a note."""
SHIFTED = ("zero", "gain")
"""Causes by which a joint reads something else in all poses."""
OF_GEOMETRY = ("length", "angle", "version")
"""Causes in the numbers of the URDF."""


def predicted_limit(limit: float) -> float:
    """Return what predicted errors of distances may come to [m], by the limit on held-out ones."""
    return max(limit, min(PREDICTED_MARGIN * limit, LARGEST_PREDICTED))


def level_of(
    consequence: Consequence,
    noise: float,
) -> str:
    """Return how much a consequence matters, by what an arm repeats [m].

    ``error``: the model could be worse than the nominal one by it, or it is more than a third of
    the limit on predicted errors of distances. ``note``: it is below a tenth of that limit.
    """
    near, everywhere = consequence.near, consequence.workspace
    share = max(near, everywhere) / predicted_limit(MARGIN * noise)
    if share <= SLIGHT:
        return "note"
    if near > consequence.near_before or everywhere > consequence.workspace_before:
        return "error"
    return "error" if share > SEVERE else "warning"


def consequence_of(
    cause: Candidate,
    training: Collection[str],
) -> Consequence | None:
    """Return what a cause does to distances near the recorded places and elsewhere.

    The model is of the placements in ``training``; of all if none is named. None: the cause
    is noise, which is part of what is known of any model.
    """
    scene = cause.scene
    if cause.kind.noise is not None:
        return None
    names = [m.name for m in scene.measurements]
    counted = [p for p, name in enumerate(names) if not training or name in training]
    without = _Fit(scene, counted)
    beside = _Fit(cause.after(), counted)
    poses = [workspace(scene.robot, POSES)]
    poses += [scene.q[scene.places[place]] for place in counted]
    shifts = [spread(beside.points(q, cause) - without.points(q)) for q in poses]
    errors = [without.nominal_error(q) for q in poses]
    everywhere, *near = shifts
    place = 1 + int(np.argmax(near))
    return Consequence(shifts[place], everywhere, errors[place], errors[0])


def nominal_errors(scene: Scene) -> float:
    """Return the errors of distances by the nominal model near the recorded places [m]."""
    fit = _Fit(scene, range(len(scene.places)))
    return max(fit.nominal_error(scene.q[rows]) for rows in scene.places)


def spread(shifts: np.ndarray) -> float:
    """Return how much distances between places change that shift so, shape (N, 3) [m].

    The distance of two places changes by the difference of their shifts along one direction: by
    |d_i - d_j| / sqrt(3), of which this is the median over random pairs.
    """
    generator = np.random.default_rng(0)
    first, second = generator.integers(len(shifts), size=(2, PAIRS))
    distances = np.linalg.norm(shifts[first] - shifts[second], axis=1)
    return float(np.median(distances[first != second])) / 3**0.5


class _Fit:
    """A robust fit to a scene, linear in all unknowns."""

    def __init__(
        self,
        scene: Scene,
        counted: Sequence[int],
    ) -> None:
        """Fit the placements of some indices."""
        self.scene = scene
        # the rows of some placements' samples
        every = range(scene.all_samples.stop)
        parts = [every[scene.rows(scene.places[place])] for place in counted]
        of_samples = [*chain.from_iterable(parts)]
        rows = of_samples + _rows_of_lengths(scene, counted)
        B = scene.nuisances[rows]
        r = scene.residuals[rows]
        count = len(of_samples)
        weights, x = np.ones(len(r)), np.zeros(B.shape[1])
        for _ in range(ROUNDS):
            errors = (r - B @ x)[:count].reshape(-1, 3)
            noise = float(typical(errors))
            weights[:count] = np.repeat(robust_weights(errors, noise), 3)
            weighted = (B * weights[:, None]).T
            precision = noise**2 / INDEPENDENT * np.eye(len(x))
            x = np.linalg.solve(weighted @ B + precision, weighted @ r)
        self._x = x

    @cached_property
    def unknowns(self) -> np.ndarray:
        """Geometry and effects of the arm, shape (size,)."""
        scene = self.scene
        widths = scene.widths_of_effects(scene.loaded_samples)
        sizes = [scene.centres.size, len(scene.parameters), len(widths)]
        _, of_geometry, of_effects, _ = np.split(self._x, np.cumsum(sizes))
        return np.concatenate([scene.usual @ of_geometry, widths * of_effects])

    def points(
        self,
        q: np.ndarray,
        cause: Candidate | None = None,
    ) -> np.ndarray:
        """Return the ball's places as the fit has them, with a cause in the arm if any."""
        if cause is None or cause.kind.name not in SHIFTED + OF_GEOMETRY:
            return self._predict(self.unknowns, q)
        unknowns, true = self.unknowns.copy(), q.copy()
        block, scene = cause.block, self.scene
        values = max(block.widths) * self._x[-block.unknowns :]
        if cause.kind.name in OF_GEOMETRY:
            columns = scene.by_geometry @ scene.usual
            shift = block.columns[0] @ values
            change = scene.usual @ np.linalg.pinv(columns, rcond=1e-6) @ shift
            unknowns[: len(change)] += change
        else:
            (names,) = block.parameters
            joint = scene.robot.joint_names.index(names["joint"])
            turns = q[:, joint] if cause.kind.name == "gain" else 1.0
            true[:, joint] += values[0] * turns
        return self._predict(unknowns, true)

    def nominal_error(self, q: np.ndarray) -> float:
        """Return the errors of distances by the nominal model with the ball of the fit [m]."""
        unknowns = np.zeros_like(self.unknowns)
        for i, parameter in enumerate(self.scene.parameters):
            unknowns[i] = parameter.of_ball * self.unknowns[i]
        return spread(self.points(q) - self._predict(unknowns, q))

    def _predict(
        self,
        unknowns: np.ndarray,
        q: np.ndarray,
    ) -> np.ndarray:
        scene = self.scene
        return scene.model.predict(unknowns, scene.load.at(scene.heavy, q))


def _rows_of_lengths(
    scene: Scene,
    counted: Sequence[int],
) -> list[int]:
    """Return the rows of the known distances between sockets of some placements."""
    names = [scene.measurements[place].name for place in counted]
    is_counted = [placement in names for placement, _ in scene.labels]
    return [
        row
        for row, length in enumerate(scene.known, scene.all_lengths.start)
        if is_counted[length.first] and is_counted[length.second]
    ]
