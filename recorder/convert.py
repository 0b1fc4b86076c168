"""Placements as the files of either form."""

import json
from dataclasses import replace

from .dataset import METADATA, Placement
from .samples import SAMPLES, capture_line, header_line

__all__ = ["hole_files", "sample_files"]


def hole_files(placement: Placement) -> dict[str, bytes]:
    """Return ``hole_0.csv``, ``hole_1.csv``, ... without a header, as the paper's authors do.

    Times, spreads and efforts have no place there.
    """
    files: dict[str, bytes] = {}
    for sample in placement.samples:
        line = ",".join(map(repr, sample.position)) + "\n"
        name = f"hole_{sample.socket}.csv"
        files[name] = files.get(name, b"") + line.encode()
    return files | _metadata(placement)


def sample_files(placement: Placement) -> dict[str, bytes]:
    """Return ``samples.csv``, its samples numbered anew; joints without a name get one."""
    count = len(placement.samples[0].position)
    names = placement.joint_names or tuple(f"joint{i + 1}" for i in range(count))
    lines = [
        capture_line(replace(sample, number=number))
        for number, sample in enumerate(placement.samples, start=1)
    ]
    return {SAMPLES: header_line(names) + b"".join(lines)} | _metadata(placement)


def _metadata(placement: Placement) -> dict[str, bytes]:
    if placement.distance is None:
        return {}
    return {METADATA: json.dumps({"distance": placement.distance}).encode() + b"\n"}
