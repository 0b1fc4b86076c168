"""The samples of a calibration, as its file keeps them."""

from collections.abc import Iterator, Sequence

from ..bayes.inference import Posterior
from ..data import Measurement
from ..results import PlacementSamples, RecordedSample, Role


def weights_by_placement(
    train: Sequence[Measurement], posterior: Posterior
) -> dict[str, list[float]]:
    """Return each training placement's robust weights, in the order of its samples."""
    weights: dict[str, list[float]] = {}
    rest = posterior.weights.tolist()
    for measured in train:
        queues: dict[int, Iterator[float]] = {}
        for socket, count in zip(measured.sockets, measured.counts, strict=True):
            queues[socket], rest = iter(rest[:count]), rest[count:]
        weights[measured.name] = [next(queues[s.socket]) for s in measured.placement.samples]
    return weights


def recorded(
    measured: Measurement, role: Role, weights: Sequence[float] | None = None
) -> PlacementSamples:
    """Return a placement's samples for the calibration file, columns in chain order.

    Args:
        measured: The placement.
        role: ``train`` or ``test``.
        weights: Robust weight of each sample, where the fit gave some.
    """
    return PlacementSamples(
        name=measured.name,
        role=role,
        distance=measured.distance,
        frame=measured.placement.frame,
        files=tuple(map(str, measured.placement.files)),
        samples=tuple(
            RecordedSample(
                socket=sample.socket,
                position=sample.position,
                effort=sample.effort,
                point=sample.point,
                where=sample.where,
                weight=None if weights is None else weights[i],
            )
            for i, sample in enumerate(measured.placement.samples)
        ),
    )
