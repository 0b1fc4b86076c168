"""Folders beside that of a session: earlier placements of its arm, and a simulated arm's bases."""

from contextlib import suppress
from operator import itemgetter
from pathlib import Path

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
from ..simulation import PRACTICE, practice_bases


def driver_elsewhere(driver: str) -> str | None:
    """Return a driver with the base elsewhere; None for a simulated arm with no base left.

    A simulated arm stays at the base of its folder, so the next folder beside it has another.
    """
    name, _, address = driver.partition(":")
    if name != PRACTICE:
        return driver
    path, mark, options = address.partition("?")
    here = Path(path)
    folders = [folder for folder in practice_bases(here) if folder > here]
    return f"{PRACTICE}:{folders[0]}{mark}{options}" if folders else None


def recorded_beside(out: Path, robot: Robot) -> tuple[Placement, ...]:
    """Return the earlier placements of this arm in neighbouring folders, oldest first.

    Those of another model are left out, and those whose :func:`_origin` is another. So are those
    before joints read otherwise: they tell nothing of the readings now.
    """
    if read_metadata(out / METADATA).get(READINGS_CHANGED) is True:
        return ()
    origin = _origin(out)
    earlier: list[tuple[float, bool, Placement]] = []  # begin [s], readings changed
    for file in out.parent.glob(f"*/{SAMPLES}"):
        folder = file.parent
        if folder.resolve() == out.resolve():
            continue
        with suppress(RecordingError):
            metadata = read_metadata(folder / METADATA)
            origin_there = _origin(folder)
            names = origin.keys() & origin_there.keys()
            is_same = all(origin[name] == origin_there[name] for name in names)
            if is_same and metadata.get("model_sha256") == robot.sha256:
                placement = read_placement(folder).for_joints(robot.joint_names)
                changed = metadata.get(READINGS_CHANGED) is True
                earlier.append((placement.samples[0].time or 0.0, changed, placement))
    placements: list[Placement] = []
    for _, changed, placement in sorted(earlier, key=itemgetter(0)):
        placements = [*([] if changed else placements), placement]
    return tuple(placements)


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
