"""Files of a placement: the recorder's form, and that of the paper's authors."""

from dataclasses import replace
from pathlib import Path

from .files import replace_files
from .metadata import metadata_file
from .placement import Placement
from .samples import SAMPLES, capture_line, header_line


def hole_files(placement: Placement) -> dict[str, bytes]:
    """Return a placement as ``hole_0.csv``, ``hole_1.csv``, ..., as the paper's authors have it.

    One configuration a line, without a header; the numbers read back exactly. Times, spreads and
    efforts are left out; a known distance is in ``placement.json``.
    """
    files: dict[str, bytes] = {}
    for sample in placement.samples:
        line = ",".join(map(repr, sample.position)) + "\n"
        name = f"hole_{sample.socket}.csv"
        files[name] = files.get(name, b"") + line.encode()
    return files | _metadata(placement)


def write_holes(placement: Placement, folder: Path) -> None:
    """Write ``hole_0.csv``, ``hole_1.csv``, ... into a folder, without a ``placement.json``.

    The folder is made if it does not exist; files of these names are overwritten.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = hole_files(replace(placement, distance=None))
    replace_files({folder / name: content for name, content in files.items()})


def sample_files(placement: Placement) -> dict[str, bytes]:
    """Return a placement as ``samples.csv``, and ``placement.json`` with a known distance, by name.

    Samples are numbered anew, from 1. Joints without a name are called joint1, joint2, ...
    """
    count = len(placement.samples[0].position)
    names = placement.joint_names or tuple(f"joint{i + 1}" for i in range(count))
    numbered = [
        replace(s, number=number) for number, s in enumerate(placement.samples, start=1)
    ]
    lines = [header_line(names), *map(capture_line, numbered)]
    return {SAMPLES: b"".join(lines)} | _metadata(placement)


def _metadata(placement: Placement) -> dict[str, bytes]:
    if placement.distance is None:
        return {}
    facts = {
        "distance": placement.distance,
        "distance_measured": not placement.distance_assumed,
    }
    return metadata_file(facts)
