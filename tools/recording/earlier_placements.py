"""Earlier placements of an arm, in neighbouring folders: a session goes on from what they tell."""

from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ...recorder import (
    METADATA,
    READINGS_CHANGED,
    SAMPLES,
    Placement,
    RecordingError,
    read_metadata,
    read_placement,
    read_sessions,
)
from ...solver.identification.robot import Robot

PRACTICE = "mock"
"""Driver of simulated arms: its address is a file of poses, not an arm's."""


class _Neighbour(NamedTuple):
    """A placement of the same arm in a neighbouring folder."""

    begin: float
    """Time of its first sample [s], since 1970."""
    placement: Placement
    readings_changed: bool
    """True if joints read otherwise than at the placements before."""


def recorded_beside(out: Path, robot: Robot) -> tuple[Placement, ...]:
    """Return the earlier placements of this arm in neighbouring folders, oldest first.

    Those of another model are left out, and those whose :func:`_origin` is another. So are those
    before joints read otherwise: they tell nothing of the readings now.
    """
    if read_metadata(out / METADATA).get(READINGS_CHANGED) is True:
        return ()
    origin = _origin(out)
    neighbours: list[_Neighbour] = []
    for file in out.parent.glob(f"*/{SAMPLES}"):
        folder = file.parent
        if folder.resolve() == out.resolve():
            continue
        with suppress(RecordingError):
            if _is_of_model(folder, robot) and _agree(origin, _origin(folder)):
                neighbours.append(_neighbour(folder, robot))
    placements: list[Placement] = []
    for neighbour in sorted(neighbours, key=lambda neighbour: neighbour.begin):
        if neighbour.readings_changed:
            placements = []
        placements.append(neighbour.placement)
    return tuple(placements)


def _is_of_model(folder: Path, robot: Robot) -> bool:
    """Return whether a placement was recorded with this model."""
    return read_metadata(folder / METADATA).get("model_sha256") == robot.sha256


def _neighbour(folder: Path, robot: Robot) -> _Neighbour:
    """Read a placement.

    Raises:
        RecordingError: It holds no sample, or has other joints than the model.
    """
    placement = read_placement(folder).for_joints(robot.joint_names)
    metadata = read_metadata(folder / METADATA)
    return _Neighbour(
        begin=placement.samples[0].time or 0.0,
        placement=placement,
        readings_changed=metadata.get(READINGS_CHANGED) is True,
    )


def _origin(folder: Path) -> dict[str, object]:
    """Return what tells one arm's placements from another's, as far as it was written down.

    These are the robot's name, its serial number and its address, each as last written. A session
    in one socket has another purpose than one in several.
    """
    file = folder / METADATA
    origin = {**read_metadata(file)}
    for session in read_sessions(file):
        origin |= session
    driver = origin.get("driver")
    if isinstance(driver, str) and driver.partition(":")[0] == PRACTICE:
        origin["driver"] = PRACTICE
    if "sockets" in origin:
        origin["one_socket"] = origin["sockets"] == 1
    names = ("robot_name", "serial_number", "driver", "one_socket")
    return {name: origin[name] for name in names if name in origin}


def _agree(origin: dict[str, object], other: dict[str, object]) -> bool:
    """Return whether two origins are one, as far as both are known."""
    return all(origin[name] == other[name] for name in origin.keys() & other.keys())
