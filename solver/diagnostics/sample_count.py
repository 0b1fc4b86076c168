"""Check of the amount of data: sockets with few samples, and placements without a known length."""

from collections.abc import Sequence

from ..data import KnownDistance, Measurement
from ..robot import Robot
from .diagnostic import Diagnostic, where_of
from .distances import named

FEWEST, ADVISED = 10, 30
"""Samples in a socket below which it tells little, and that are advised."""


def few_samples(_: Robot, measured: Measurement) -> list[Diagnostic]:
    """Return sockets of a placement with too few samples."""
    return [
        Diagnostic(
            "warning",
            "few",
            where_of([measured]),
            f"{count} samples in socket {socket}",
            f"record {ADVISED - count} more: {ADVISED} are advised, {FEWEST} are the least",
        )
        for socket, count in zip(measured.sockets, measured.counts, strict=True)
        if count < FEWEST
    ]


def single_socket_diagnostics(
    measurements: Sequence[Measurement], known: Sequence[KnownDistance] = ()
) -> list[Diagnostic]:
    """Return placements with one socket, which no known distance ties to a length."""
    whole = named(measurements, known)
    scaled = {name for k in whole for name, _ in (k.first, k.second)}
    return [
        Diagnostic(
            "error",
            "lone",
            where_of([m]),
            f"only socket {m.sockets[0]} has samples, so solve refuses it",
            "record the other socket too, or tie it by a known distance, solve --known",
        )
        for m in measurements
        if m.kind == "sockets" and not m.has_distance and m.name not in scaled
    ]
