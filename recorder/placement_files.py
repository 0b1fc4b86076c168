"""Files of a placement: the recorder's form, and that of the paper's authors."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from .coordinates import AXES, QUATERNION
from .files import replace_files
from .metadata import Contents, metadata_file
from .placement import DEFAULT_DISTANCE, Placement
from .points import POINTS, POSES
from .recording_error import RecordingError
from .samples import SAMPLES, capture_line, header_line

Files = dict[str, bytes]
"""Contents of files by their names."""
_MEASURED = b"# measured flange poses\n"


def hole_files(placement: Placement) -> Files:
    """Return a placement as ``hole_0.csv``, ``hole_1.csv``, ..., as the paper's authors have it.

    One configuration a line, without a header; the numbers read back exactly. Times, spreads and
    efforts are left out; a known distance is in ``placement.json``.
    """
    files: Files = {}
    for sample in placement.samples:
        line = ",".join(map(repr, sample.position)) + "\n"
        name = f"hole_{sample.socket}.csv"
        files[name] = files.get(name, b"") + line.encode()
    return files | _metadata(placement)


def write_holes(placement: Placement, folder: Path) -> None:
    """Write :func:`hole_files` into a folder.

    The folder is made if it does not exist; files of these names are overwritten.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = hole_files(placement)
    replace_files({folder / name: content for name, content in files.items()})


def sample_files(placement: Placement) -> Files:
    """Return a placement as ``samples.csv``, and ``placement.json`` with a known distance, by name.

    Samples are numbered anew, from 1. Times that are not known stay empty, and then nobody relies
    on the order of sockets. Joints without a name are called joint1, joint2, ...
    """
    names = _names(placement)
    numbered = [
        replace(s, number=number) for number, s in enumerate(placement.samples, start=1)
    ]
    lines = [header_line(names), *map(capture_line, numbered)]
    return {SAMPLES: b"".join(lines)} | _metadata(placement)


def _metadata(placement: Placement) -> Files:
    if placement.distance is None:
        return {}
    facts: Contents = {"distance": placement.distance}
    if placement.distance == DEFAULT_DISTANCE:  # else taken for assumed
        facts["distance_measured"] = not placement.distance_assumed
    return metadata_file(facts)


def point_files(placement: Placement) -> Files:
    """Return the content of ``points.csv`` by its name; orientations have no place in it."""
    return {POINTS: _measured(placement, AXES)}


def pose_files(placement: Placement) -> Files:
    """Return the content of ``poses.csv`` by its name: measured poses of the flange."""
    table = _measured(placement, (*AXES, *QUATERNION))
    return {POSES: _MEASURED + table}


def _measured(placement: Placement, columns: Sequence[str]) -> bytes:
    """Return joint positions and what an instrument measured there, as a table."""
    lines = [",".join((*_names(placement), *columns))]
    for sample in placement.samples:
        if len(columns) > len(AXES) and sample.orientation is None:
            raise RecordingError(
                f"{placement.name}: no instrument measured orientations"
            )
        if sample.point is None:
            raise RecordingError(
                f"{placement.name}: no instrument measured it; give --to samples"
            )
        measured = (*sample.point, *(sample.orientation or ()))[: len(columns)]
        lines.append(",".join(map(repr, (*sample.position, *measured))))
    return ("\n".join(lines) + "\n").encode()


def own_files(placement: Placement) -> Files:
    """Return a placement in the form that holds all that was measured."""
    first, *_ = placement.samples
    if first.point is None:
        return sample_files(placement)
    return pose_files(placement) if first.orientation else point_files(placement)


def _names(placement: Placement) -> tuple[str, ...]:
    count = len(placement.samples[0].position)
    return placement.joint_names or tuple(f"joint{i + 1}" for i in range(count))
