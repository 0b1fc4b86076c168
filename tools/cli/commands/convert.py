"""``mukca convert``: write recordings in the other form."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

from .... import recorder
from ....solver.results import OutputError, refuse_existing, write_files
from .. import POSITIVE, Terminal, argument, option, placement_of_table, point_files

FORMS = {"samples": recorder.sample_files, "holes": recorder.hole_files, "points": point_files}


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of ``mukca convert``."""

    path: Path = argument("a placement, or a folder of them; with --columns a table", "PATH")
    to: str = option(
        "samples.csv; hole_0.csv and hole_1.csv; or points.csv of an instrument",
        default=...,
        choices=FORMS,
    )
    columns: Sequence[str] = option(
        "what the columns of another program's table are, as in 'q=joint_1..6 [deg]' "
        "'x=x_t+x_dif [mm]'; also y, z, socket, effort",
        "NAME=COLUMNS",
        (),
    )
    out: Path = option("where to write", "DIR", ...)
    force: bool = option("overwrite files in DIR", default=False)
    distance: float | None = option(
        "distance of the sockets' centres in metres, where the recording does not say",
        "M",
        between=POSITIVE,
    )


def run(options: Options, terminal: Terminal) -> int:
    """Read all placements, then write them."""
    refuse_existing(options.out, force=options.force)
    folders = [options.path] if options.columns else recorder.find_placements([options.path])
    placements = [
        placement_of_table(folder, options.columns)
        if options.columns
        else recorder.read_placement(folder)
        for folder in folders
    ]
    outs = [options.out if f == options.path else options.out / f.name for f in folders]
    for folder, out in zip(folders, outs, strict=True):
        if out.resolve() == folder.resolve():
            raise OutputError(f"{out}: is what is read; choose another --out")
    for folder, placement, out in zip(folders, placements, outs, strict=True):
        terminal.warn(*placement.remarks)
        known = replace(placement, distance=placement.distance or options.distance)
        files = FORMS[options.to](known)
        metadata = {} if options.columns else recorder.read_metadata(folder / recorder.METADATA)
        if metadata:
            metadata["distance"] = known.distance
            files[recorder.METADATA] = json.dumps(metadata, indent=2).encode() + b"\n"
        for file in [*out.glob("hole_*.csv"), *out.glob("samples.csv")]:
            if file.name not in files:
                raise OutputError(f"{file}: another recording is there; choose another --out")
        terminal.say(*(f"Wrote {file}" for file in write_files(out, files).values()))
        if options.to == "holes" and placement.efforts is not None:
            terminal.warn(f"{folder}: this form has no place for efforts; they are left out")
        if options.to == "holes" and any(b < a for a, b in pairwise(placement.sockets)):
            lost = "this form loses the order of recording, by which a base that moved is seen"
            terminal.warn(f"{folder}: {lost}")
    return 0
