"""``mukca convert``: recordings in another form, or of columns that users name."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import chain, pairwise
from pathlib import Path

from .... import recorder
from ....recorder import Placement
from ....solver.results import OutputError, refuse_existing, write_files
from .. import POSITIVE, JsonOption, TableOptions, Terminal, argument, option

FORMS = {
    "samples": recorder.sample_files,
    "holes": recorder.hole_files,
    "points": recorder.point_files,
    "poses": recorder.pose_files,
}


class _ConvertOptions(TableOptions, JsonOption):
    path: Path = argument("a placement, a folder of them, or a table", "PATH")
    to: str = option(
        ...,
        "samples.csv; hole_0.csv and hole_1.csv; points.csv or poses.csv of an instrument",
        choices=FORMS,
    )
    out: Path = option(..., "where to write", "DIR")
    force: bool = option(False, "overwrite files in DIR")
    distance: float | None = option(
        None,
        "distance of the sockets' centres in metres, where the recording does not say",
        "M",
        between=POSITIVE,
    )


def run_convert(options: _ConvertOptions, terminal: Terminal) -> int:
    """Read all placements, then write them."""
    refuse_existing(options.out, force=options.force)
    folders = recorder.find_placements([options.path])
    placements = {f: recorder.read_placement(f, **options.table) for f in folders}
    outs: dict[Path, Path] = {}
    for folder in placements:
        out = options.out if folder == options.path else options.out / folder.name
        if out.resolve() == folder.resolve():
            raise OutputError(f"{out}: is what is read; choose another --out")
        outs[folder] = out
    outputs: list[str] = []
    all_losses: list[str] = []
    for folder, placement in placements.items():
        terminal.warn(*placement.remarks)
        out = outs[folder]
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
    distance = placement.distance or options.distance
    files = FORMS[options.to](replace(placement, distance=distance))
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
    if any(sample.time is not None for sample in placement.samples) or any(
        next_socket < socket for socket, next_socket in pairwise(placement.sockets)
    ):
        losses.append(
            "this form loses the order of recording, by which a base that moved is seen"
        )
    return losses
