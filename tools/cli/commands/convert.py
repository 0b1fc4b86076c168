"""``mukca convert``: write recordings in the other form."""

import argparse
import json
import math
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from ....recorder import (
    METADATA,
    find_placements,
    hole_files,
    read_metadata,
    read_placement,
    sample_files,
)
from ....solver.results import OutputError, refuse_existing, write_files
from .. import Terminal
from ..robot_arguments import UsageError

EXAMPLE = """example:
  mukca convert data/front --to holes --out front_for_the_authors_program

A folder of placements becomes a folder of placements. Samples that were taken back are left out;
what placement.json says is kept."""

FORMS = {"samples": sample_files, "holes": hole_files}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    parser.add_argument("path", type=Path, metavar="PATH", help="a placement, or a folder of them")
    parser.add_argument(
        "--to", required=True, choices=FORMS, help="samples.csv, or hole_0.csv and hole_1.csv"
    )
    parser.add_argument("--out", required=True, type=Path, metavar="DIR", help="where to")
    parser.add_argument("--force", action="store_true", help="overwrite files in DIR")
    parser.add_argument(
        "--distance",
        type=float,
        metavar="M",
        help="distance of the sockets' centres in metres, where the recording does not say",
    )


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Read all placements, then write them."""
    refuse_existing(arguments.out, force=arguments.force)
    if arguments.distance is not None and not 0 < arguments.distance < math.inf:
        raise UsageError(f"--distance {arguments.distance:g}: expected a positive number of metres")
    folders = find_placements([arguments.path])
    placements = [read_placement(folder) for folder in folders]
    outs = [arguments.out if f == arguments.path else arguments.out / f.name for f in folders]
    for folder, out in zip(folders, outs, strict=True):
        if out.resolve() == folder.resolve():
            raise OutputError(f"{out}: is what is read; choose another --out")
    for folder, placement, out in zip(folders, placements, outs, strict=True):
        for remark in placement.remarks:
            terminal.warn(remark)
        known = replace(placement, distance=placement.distance or arguments.distance)
        files = FORMS[arguments.to](known)
        metadata = read_metadata(folder / METADATA)
        if metadata:
            metadata["distance"] = known.distance
            files[METADATA] = json.dumps(metadata, indent=2).encode() + b"\n"
        _refuse_mixture(out, files)
        for file in write_files(out, files).values():
            terminal.say(f"Wrote {file}")
        if arguments.to == "holes" and placement.efforts is not None:
            terminal.warn(f"{folder}: this form has no place for efforts; they are left out")
    return 0


def _refuse_mixture(out: Path, files: Collection[str]) -> None:
    """See that a folder will not hold two recordings."""
    for file in [*out.glob("hole_*.csv"), *out.glob("samples.csv")]:
        if file.name not in files:
            raise OutputError(f"{file}: another recording is there; choose another --out")
