"""Samples of a ball in sockets, as rows of a fit."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import chain, compress

import numpy as np

from ...recorder import Placement
from ..assessment import measured_distances
from ..calibration import Calibration, UsageError
from ..identification.data import Measurement, measure
from ..identification.robot import Robot
from .fit import fit
from .prior import SOCKET, ArmPrior, prior_of
from .task import FAR, NoiseBelief, Rows, Task

SIMILAR = 0.2
"""Largest range of a joint over the samples of a socket whose postures are similar [rad], [m]."""
FEWEST_SAMPLES = 10
"""New samples below which there is no verdict."""
ANY_ARM = 20.0
"""Factor on the tolerances of a nominal arm that is known by its samples alone."""


@lru_cache(maxsize=2)
def prior_by_all_samples(calibration: Calibration) -> ArmPrior:
    """Return the prior of an arm by all samples of its calibration, held-out ones included.

    One without a posterior is fitted to its samples again.
    """
    document, robot = calibration.document, calibration.calibrated.robot
    if document.method == "auto" and document.arms is None:
        prior, roles = prior_of(calibration), ("test",)
    else:
        nominal, roles = prior_of(robot), ("train", "test")
        prior = replace(
            nominal,
            covariance=ANY_ARM**2 * nominal.covariance,
            load=calibration.calibrated.load,
            noise=replace(nominal.noise, joint=0.0),
        )
    data = [
        measure(row.placement(robot.joint_names), robot, sockets=1)
        for row in document.data
        if row.role in roles and row.samples[0].point is None
    ]
    if not data:
        return prior
    system = fit(socket_task(prior, data))
    unknowns = slice(len(prior.mean))
    return replace(
        prior,
        mean=prior.mean + system.shift,
        covariance=system.posterior_covariance(unknowns),
        noise=replace(prior.noise, space=system.state.noise.place),
    )


def socket_task(prior: ArmPrior, data: Sequence[Measurement], stood: str = "") -> Task:
    """Return the task of a fit to a ball in sockets, with the arm as it was calibrated."""
    if any(m.kind == "points" for m in data):
        raise UsageError(
            "give placements with the ball in sockets, not measured points: by points, mukca "
            "solve --zeros finds the zeros anew"
        )
    pairs = [*chain.from_iterable(m.labels for m in data)]
    counts = [*chain.from_iterable(m.counts for m in data)]
    names = [
        _known_socket(prior, stood, *pair) if stood else str(pair) for pair in pairs
    ]
    places = np.repeat(np.arange(len(pairs)), counts)
    rows = Rows.of(prior, data, places, tuple(names))
    distances: list[tuple[int, int, float]] = []
    first = 0  # by their order, since two placements may have one name
    for m in data:
        if m.has_distance:
            distances.append((first, first + 1, m.distance))
        first += len(m.sockets)
    return Task(prior, rows, _noise_of(prior), distances=distances)


def point_task(prior: ArmPrior, data: Sequence[Measurement]) -> Task:
    """Return the task of a fit to measured points, each placement in a frame of its own.

    The target is put on anew from day to day: its place on the flange is free.
    """
    places = np.repeat(np.arange(len(data)), [len(m.points) for m in data])
    rows = Rows.of(prior, data, places, tuple(f"frame at {m.name}" for m in data))
    right = rows.right.copy()
    right[:, :3, 3] = np.concatenate([m.points for m in data])
    task = Task(prior, replace(rows, right=right, framed=True), _noise_of(prior))
    return task.freeing(dict.fromkeys(prior.ball.tolist(), FAR))


def _noise_of(prior: ArmPrior) -> NoiseBelief:
    """Return the belief that samples are as noisy as those of the calibration."""
    return NoiseBelief(prior.noise.space, joint=prior.noise.joint, nu=prior.noise.nu)


def on_base_of(arm: Calibration | Robot, placement: Placement) -> Placement:
    """Return samples that state no distance with that of the calibration's base, and a remark."""
    is_stated = placement.distance is not None and not placement.distance_assumed
    is_apart = placement.kind != "points" and len(set(placement.sockets)) > 1
    if is_stated or not is_apart or not isinstance(arm, Calibration):
        return placement
    distances = measured_distances(arm.document)
    if len(distances) != 1:
        return placement
    (distance,) = distances
    remark = (
        f"{placement.name}: states no distance, so that of the calibration's base is taken, "
        f"{1e3 * distance:.5g} mm; for another base give --distance"
    )
    return replace(
        placement,
        distance=distance,
        distance_assumed=False,
        remarks=(*placement.remarks, remark),
    )


def similar_postures(data: Sequence[Measurement]) -> bool:
    """Return True where the postures in each socket are too similar to identify anything."""
    by_socket = chain.from_iterable(m.by_socket for m in data)
    return all(bool(np.ptp(q, axis=0).max() < SIMILAR) for q in by_socket)


def too_few(data: Sequence[Measurement], *, unchanged: bool) -> str:
    """Return why there are too few samples; empty where there are enough.

    Similar postures are too few where nothing seems to have changed (``unchanged``).
    """
    count = sum(len(m.positions) for m in data)
    if count < FEWEST_SAMPLES:
        return f"{count} samples say too little; record 6 in each of two sockets."
    if not unchanged or not similar_postures(data):
        return ""
    return (
        f"{count} samples in postures alike say too little; record 6 in each of two sockets, all "
        "joints moved from one to the next."
    )


def new_samples(
    arm: Calibration | Robot, data: Sequence[Measurement]
) -> tuple[Sequence[Measurement], bool, list[str]]:
    """Return the samples that an arm was not trained on, or all; whether any is new; and remarks.

    Samples that count twice would make the estimates look more certain than they are.
    """
    used = [isinstance(arm, Calibration) and arm.was_trained_on(m) for m in data]
    if not any(used):
        return data, True, []
    names = ", ".join(m.name for m in compress(data, used))
    if not all(used):
        new = [m for m, is_used in zip(data, used, strict=True) if not is_used]
        return new, True, [f"{names}: trained on, and left out"]
    remark = (
        f"{names}: the calibration was made from these samples, so they cannot show a later "
        "change; record 6 new samples in each of two sockets"
    )
    return data, False, [remark]


def _known_socket(prior: ArmPrior, stood: str, placement: str, socket: int) -> str:
    """Return the name of the calibration's socket that has not moved since."""
    last = SOCKET.format(stood, socket)
    matches = [
        name for name in prior.sockets if name == last or name.endswith(f"/{last}")
    ]
    if len(matches) != 1:
        names = ", ".join(prior.sockets) or "none"
        raise UsageError(
            f"{placement}: socket {socket} does not stand where {stood!r} was calibrated; "
            f"sockets there (PLACEMENT:SOCKET): {names}"
        )
    return matches[0]


def require_samples(task: Task, zeros: int) -> None:
    """Refuse a task of fewer numbers than unknowns, with so many zeros of joints."""
    count = len(task.rows.q)
    sockets = len(task.rows.names)
    new_sockets = sockets - len(task.known)
    numbers = 3 * count + len(task.distances)
    unknowns = 3 * new_sockets + zeros
    if numbers <= unknowns:
        raise UsageError(
            f"{count} samples for {zeros} zeros and {sockets} sockets; record 6 in each"
        )
