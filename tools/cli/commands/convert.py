"""``mukca convert`` and ``export``: recordings and calibrations as other programs read them."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from itertools import chain
from pathlib import Path
from typing import Literal

import numpy as np

from .... import recorder
from ....recorder import Placement
from ....solver import calibration
from ....solver.calibration import UsageError
from ....solver.results import OutputError, refuse_existing, write_files
from ... import export
from ...export import format_table
from .. import (
    JsonOption,
    PayloadOptions,
    TableOptions,
    Terminal,
    for_each_arm,
    option,
    warn_of_use,
)

_FORMS = {
    "samples": recorder.sample_files,
    "holes": recorder.hole_files,
    "points": recorder.point_files,
    "poses": recorder.pose_files,
}
OF_SOCKETS = ("samples", "holes")
"""Forms that hold no place of a point."""


class _ConvertOptions(TableOptions, JsonOption):
    path: Path
    to: str = option(
        ...,
        "samples.csv; hole_0.csv and hole_1.csv; points.csv or poses.csv of an instrument",
        choices=_FORMS,
    )
    out: Path
    force: bool = False
    distance: float | None = None


def run_convert(options: _ConvertOptions, terminal: Terminal) -> int:
    """Read all placements, then write them."""
    refuse_existing(options.out, force=options.force)
    folders = recorder.find_placements([options.path])
    placements = {f: recorder.read_placement(f, **options.table) for f in folders}
    outs = [options.out / ("" if f == options.path else f.name) for f in folders]
    for folder, out in zip(folders, outs, strict=True):
        recorder.require_near(placements[folder])
        if out.resolve() == folder.resolve():
            raise OutputError(f"{out}: is what is read; choose another --out")
    outputs: list[str] = []
    all_losses: list[str] = []
    for (folder, placement), out in zip(placements.items(), outs, strict=True):
        terminal.warn(*placement.remarks)
        files = _files(folder, placement, options)
        refuse_another_form(out, files)
        if (out / recorder.METADATA).exists():
            # Keys of an earlier recording there say nothing of this one.
            files = recorder.metadata_file({}) | files
        written = write_files(out, files)
        outputs += map(str, written.values())
        terminal.say(*(f"Wrote {file}" for file in written.values()))
        if options.to == "holes":
            losses = [f"{folder}: {loss}" for loss in _losses(placement)]
            terminal.warn(*losses)
            all_losses += losses
    terminal.emit({"outputs": outputs, "losses": all_losses})
    return 0


def _files(
    folder: Path, placement: Placement, options: _ConvertOptions
) -> dict[str, bytes]:
    """Return the files of a placement in the form that is asked for, by their names."""
    is_measured = any(sample.point for sample in placement.samples)
    if is_measured and options.to in OF_SOCKETS:
        raise OutputError(
            f"{folder}: an instrument measured points, which --to {options.to} would lose; "
            "give --to points"
        )
    distance = placement.distance or options.distance
    files = _FORMS[options.to](replace(placement, distance=distance))
    metadata = recorder.read_metadata(folder / recorder.METADATA)
    if metadata:
        metadata["distance"] = distance
        files |= recorder.metadata_file(metadata)
    return files


def refuse_another_form(out: Path, files: Mapping[str, bytes]) -> None:
    """Refuse a folder that holds a recording which would not be overwritten.

    Raises:
        OutputError: There is one.
    """
    forms = ("hole_*.csv", "samples.csv", "points.csv", "poses.csv")
    for file in chain.from_iterable(map(out.glob, forms)):
        if file.name not in files:
            raise OutputError(
                f"{file}: another recording is there; choose another --out"
            )


def _losses(placement: Placement) -> list[str]:
    """Return what the paper's form has no place for, in words."""
    losses: list[str] = []
    if placement.efforts is not None:
        losses.append("this form has no place for efforts; they are left out")
    has_times = any(sample.time is not None for sample in placement.samples)
    if has_times or (np.diff(placement.sockets) < 0).any():
        losses.append(
            "this form loses the order of recording, by which a base that moved is seen"
        )
    return losses


FORMATS = format_table()
LIST = "\n".join(f"  {name:<11} {format_.line}" for name, format_ in FORMATS.items())


class _ExportOptions(PayloadOptions, JsonOption):
    calibration: Path
    to: str = option(..., "one of the formats below", "FORMAT", choices=FORMATS)
    out: Path
    flange: str | None = None
    tool: Sequence[str] = ()
    like: Path | None = None
    joints: str | None = None
    servos: Literal["feetech", "dynamixel"] | None = None
    rows: int | None = None
    serial_number: str | None = None
    force: bool = False


@for_each_arm
def run_export(options: _ExportOptions, terminal: Terminal) -> int:
    """Write the files, and print what the format cannot express."""
    tools = _tools(options.tool)
    loaded = calibration.load_calibration(options.calibration)
    if loaded.document.distorted:
        places = ", ".join(loaded.document.distorted)
        terminal.warn(
            f"{options.calibration}: the model does not reproduce the sockets' distance at "
            f"{places}; it was accepted by --accept-distorted"
        )
    names = ("serial_number", "force", "like", "joints", "servos", "flange", "rows")
    settings = {name: getattr(options, name) for name in names}
    settings |= {"tools": tools, "payload": options.carried}
    exported = export.export(loaded, options.to, options.out, **settings)
    warn_of_use(loaded, terminal)
    wrote = (f"Wrote {file}" for file in exported.outputs.values())
    terminal.say(*map(str, exported.losses), *exported.lines, *wrote)
    losses = [asdict(loss) for loss in exported.losses]
    terminal.emit({"format": options.to, "outputs": exported.outputs, "losses": losses})
    return 0


def _tools(words: Sequence[str]) -> dict[str, tuple[float, ...]]:
    tools: dict[str, tuple[float, ...]] = {}
    for word in words:
        name, _, place = word.partition("=")
        try:
            numbers = tuple(map(float, place.split(",")))
        except ValueError:
            numbers = ()
        if not name or name in tools or not numbers:
            raise UsageError(
                f"--tool {word}: give each a name of its own, a place in metres and a turn in "
                "radians, as in --tool gripper=0,0,0.12,0,0,1.57"
            )
        tools[name] = numbers
    return tools
