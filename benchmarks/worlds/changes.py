"""Changes that make recordings awkward, each of one placement, by name."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from mukca.recorder import Placement

Change = Callable[[Placement, np.random.Generator], Placement]


def picked(placement: Placement, rows: Sequence[int] | np.ndarray) -> Placement:
    return replace(placement, samples=tuple(placement.samples[i] for i in rows))


def _moved(placement: Placement, q: np.ndarray) -> Placement:
    """Return the placement as if the joints had been read elsewhere, at q [rad]."""
    pairs = zip(placement.samples, q.tolist(), strict=True)
    return replace(
        placement, samples=tuple(replace(s, position=tuple(row)) for s, row in pairs)
    )


def _displaced(placement: Placement, off: np.ndarray) -> Placement:
    """Return the placement with measured balls elsewhere, by rows of shape (N, 3) [m]."""
    if any(sample.point is None for sample in placement.samples):
        return placement
    points = np.array([sample.point for sample in placement.samples]) + off
    pairs = zip(placement.samples, points.tolist(), strict=True)
    return replace(
        placement, samples=tuple(replace(s, point=(*row,)) for s, row in pairs)
    )


def _thinned(count: int) -> Change:
    """Return the change to so many samples of each socket; of measured balls to twice as many."""

    def change(placement: Placement, generator: np.random.Generator) -> Placement:
        kept: list[int] = []
        for socket in np.unique(placement.sockets):
            rows = generator.permutation(np.flatnonzero(placement.sockets == socket))
            measured = placement.samples[rows[0]].point is not None
            kept += rows[: 2 * count if measured else count].tolist()
        return picked(placement, sorted(kept))

    return change


def _nearly_empty(placement: Placement, generator: np.random.Generator) -> Placement:
    rows = np.flatnonzero(placement.sockets == placement.sockets.max())
    dropped = generator.permutation(rows)[2:]
    return picked(placement, np.setdiff1d(np.arange(len(placement.samples)), dropped))


def _joint_off(placement: Placement, generator: np.random.Generator) -> Placement:
    q = placement.positions.copy()
    q[:, generator.integers(q.shape[1])] += 0.2
    return _moved(placement, q)


def _noisy(placement: Placement, generator: np.random.Generator) -> Placement:
    q = placement.positions
    return _moved(placement, q + generator.normal(0, 3e-3, q.shape))


def _repeated(placement: Placement, generator: np.random.Generator) -> Placement:
    fewer = _thinned(4)(placement, generator)
    return picked(fewer, np.repeat(np.arange(len(fewer.samples)), 4))


def _alike(placement: Placement, generator: np.random.Generator) -> Placement:
    """The seven postures of each socket that are most like some posture of it."""
    kept: list[int] = []
    for socket in np.unique(placement.sockets):
        rows = np.flatnonzero(placement.sockets == socket)
        q = placement.positions[rows]
        away = np.linalg.norm(q - q[generator.integers(len(q))], axis=1)
        kept += rows[np.argsort(away)[:7]].tolist()
    return picked(placement, sorted(kept))


def _at_rest(placement: Placement, generator: np.random.Generator) -> Placement:
    """Every sample of a socket is its first posture, but for what encoders flicker."""
    first = {
        s: placement.sockets.tolist().index(s) for s in set(placement.sockets.tolist())
    }
    q = placement.positions[[first[s] for s in placement.sockets.tolist()]]
    return _moved(placement, q + generator.normal(0, 1e-6, q.shape))


def _subset(placement: Placement, generator: np.random.Generator) -> Placement:
    kept = generator.random(len(placement.samples)) < generator.uniform(0.2, 0.9)
    return picked(placement, np.flatnonzero(kept) if kept.any() else [0])


def _sockets_swapped(placement: Placement, generator: np.random.Generator) -> Placement:
    swapped = (generator.random(len(placement.samples)) < 0.15).tolist()
    pairs = zip(placement.samples, swapped, strict=True)
    samples = (replace(s, socket=1 - s.socket) if swap else s for s, swap in pairs)
    return (
        replace(placement, samples=tuple(samples))
        if placement.sockets.any()
        else placement
    )


def _columns_swapped(placement: Placement, generator: np.random.Generator) -> Placement:
    q = placement.positions.copy()
    a, b = generator.choice(q.shape[1], 2, replace=False)
    q[:, [a, b]] = q[:, [b, a]]
    return _moved(placement, q)


def _sign_flipped(placement: Placement, generator: np.random.Generator) -> Placement:
    q = placement.positions.copy()
    q[:, generator.integers(q.shape[1])] *= -1
    return _moved(placement, q)


def _joint_still(placement: Placement, generator: np.random.Generator) -> Placement:
    q = placement.positions.copy()
    joint = generator.integers(q.shape[1])
    q[:, joint] = q[0, joint]
    return _moved(placement, q)


def _nonsense(placement: Placement, generator: np.random.Generator) -> Placement:
    return _moved(placement, generator.uniform(-2, 2, placement.positions.shape))


def _one_far_off(placement: Placement, generator: np.random.Generator) -> Placement:
    q = placement.positions.copy()
    q[generator.integers(len(q))] += generator.normal(0, 0.3, q.shape[1])
    return _moved(placement, q)


def _other_marker(placement: Placement, generator: np.random.Generator) -> Placement:
    every_second = (np.arange(len(placement.samples)) % 2)[:, None]
    return _displaced(placement, every_second * np.array([0.15, 0.0, 0.0]))


def _mirrored(placement: Placement, generator: np.random.Generator) -> Placement:
    points = np.array([sample.point or (0.0, 0.0, 0.0) for sample in placement.samples])
    return _displaced(placement, -2 * points * np.eye(3)[generator.integers(3)])


def _points_scattered(
    placement: Placement, generator: np.random.Generator
) -> Placement:
    return _displaced(placement, generator.normal(0, 0.06, (len(placement.samples), 3)))


CHANGES: dict[str, Change] = {
    **{f"{count} samples": _thinned(count) for count in range(1, 16)},
    "one socket nearly empty": _nearly_empty,
    "one joint off by 0.2 rad": _joint_off,
    "3 mrad of noise": _noisy,
    "rows repeated": _repeated,
    "postures alike": _alike,
    "one posture": _at_rest,
    "a random part": _subset,
    "sockets swapped": _sockets_swapped,
    "columns swapped": _columns_swapped,
    "a sign flipped": _sign_flipped,
    "a joint held still": _joint_still,
    "nonsense": _nonsense,
    "one sample far off": _one_far_off,
    "points of two markers": _other_marker,
    "points mirrored": _mirrored,
    "points scattered": _points_scattered,
}
"""What recordings are spoilt by; the last three do nothing to a ball in a socket."""
