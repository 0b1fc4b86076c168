"""The arm that an emulated controller moves, and the faults of its messages."""

import math
import random
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ...drivers.arms import Fault, Motion, SimulatedArm
from ...errors import MukcaError, read_beside
from ...recorder import read_placement

POSES = 40
ROUNDS = 1000  # a motion has an end; at 2 s a pose this one lasts for a day
SPREAD = 0.6  # rad, to each side of the middle
ELBOW = -1.2  # rad: a middle that is not straight
GREATEST_EFFORT = 30.0  # N m


def emulated_arm(
    joints: int,
    rate: float,
    motion: tuple[float, float],
    noise: float,
    folder: Path | None,
) -> SimulatedArm:
    """Return an arm that goes through a placement's configurations, or again and again through 40.

    ``motion`` is the duration of each rest and each move [s], ``noise`` that of the encoders [rad].
    Poses and efforts that are no placement's are invented. A placement of another robot is a
    MukcaError.
    """
    if folder is None:
        poses, efforts = _invented(joints)
    else:
        placement = read_placement(folder)
        poses = placement.positions.tolist()
        efforts = None if placement.efforts is None else placement.efforts.tolist()
        if len(poses[0]) != joints:
            raise MukcaError(
                f"{folder}: {len(poses[0])} joints, but this controller's arm has {joints}"
            )
    hold, move = motion
    path = Motion(poses, hold=hold, move=move)
    return SimulatedArm(path, efforts=efforts, rate=rate, noise=noise)


def _invented(joints: int) -> tuple[list[list[float]], list[list[float]]]:
    """Return random poses near one that reaches forwards, and their efforts."""
    source = random.Random(joints)  # noqa: S311 - poses, no secret
    middle = [ELBOW if joint % 2 else 0.0 for joint in range(joints)]
    poses = list[list[float]]()
    efforts = list[list[float]]()
    for _ in range(POSES):
        pose = [q + source.uniform(-SPREAD, SPREAD) for q in middle]
        poses.append(pose)
        efforts.append([GREATEST_EFFORT * math.sin(q) for q in pose])
    return poses * ROUNDS, efforts * ROUNDS


KINDS: dict[str, str] = read_beside(__file__, "faults.json")
"""Kinds of faults; not every controller has a way to show the last three."""
COMMON_KINDS = tuple(KINDS)[:-3]

Packet = tuple[Any, bytes]
"""A message: its CAN identifier or UDP address, if it has one, and its bytes."""


class FaultInjector:
    """Applies faults to the messages of a controller."""

    def __init__(self, faults: Sequence[Fault], seed: int) -> None:
        self._faults = faults
        self._random = random.Random(seed)  # noqa: S311 - noise, no secret
        self._held_back: list[Packet] = []
        self._stalled: list[Packet] = []

    def is_active(self, kind: str, moment: float) -> bool:
        """Return whether a kind of fault affects a message at a moment [s]."""
        return any(
            fault.kind == kind and fault.affects(moment, self._random)
            for fault in self._faults
        )

    def packets(self, packet: Packet, moment: float) -> list[Packet]:
        """Return the packets that are sent in a packet's stead, in order."""
        if not self._faults:
            return [packet]
        shows = partial(self.is_active, moment=moment)
        if shows("silent") or shows("drop"):
            return []
        target, message = packet
        if shows("truncate"):
            message = message[: self._random.randrange(len(message))]
        if shows("garble"):
            message = self._random.randbytes(len(message))
        packet = target, message
        if shows("reorder") and not self._held_back:
            self._held_back = [packet]
            return []
        copies = [packet] * (1 + shows("duplicate"))
        sent = [*self._stalled, *copies, *self._held_back]
        self._held_back = []
        self._stalled = sent if shows("stall") else []
        return [] if self._stalled else sent
