"""A stored set of files, which every later version reads, and of whose keys none is lost.

    python tests/stored.py [FOLDER]           check one set, or all below tests/stored
    python tests/stored.py --write FOLDER     make a set with the present version, at a release

A set holds recordings in both forms, a calibration by them, the public names, and the exit status
and the keys of every JSON object that was printed. Keys and names may be added.
"""

import argparse
import io
import json
import os
import shutil
import sys
import tempfile
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path

import mukca
from mukca.recorder import hole_files, sample_files
from mukca.tools.cli import main

STORED = Path(__file__).with_name("stored")
COMMANDS = Path(__file__).with_name("stored_commands.txt").read_text().splitlines()
FREE = {"versions", "data_sha256", "deflection", "settings", "metadata"}
FREE |= {"parameters", "probabilities"}
"""Whose keys are names of other things."""


def keys(value, path=""):
    """Yield the way to every key; items of a list count as one."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield f"{path}.{key}"
            if key not in FREE or isinstance(inner, list):
                yield from keys(inner, f"{path}.{key}")
    elif isinstance(value, list):
        for inner in value:
            yield from keys(inner, f"{path}[]")


@contextmanager
def inside(folder):
    """Work in a folder for a while."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def printed(words):
    """Return the exit status of a command, and the keys that it prints."""
    out = io.StringIO()
    with redirect_stdout(out), redirect_stderr(io.StringIO()):
        status = main([*words.split(), "--json"])
    found = json.loads(out.getvalue()) if status in (0, 1, 3) else {}
    return {"status": status, "keys": sorted(set(keys(found)))}


def write(folder):
    """Make a set."""
    robot = mukca.load_robot("panda")
    _, placements = mukca.simulate_recordings(robot, 3, samples=10, seed=1)
    forms = (sample_files, hole_files, sample_files)
    for name, files, placement in zip(("front", "left", "right"), forms, placements, strict=True):
        (folder / name).mkdir(parents=True)
        for file, data in files(placement).items():
            (folder / name / file).write_bytes(data)
    with inside(folder):
        words = "solve front --test left --robot panda --distance 0.05 --out calibrated"
        main(words.split())
    for name in ("report.html", "report.json"):
        (folder / "calibrated" / name).unlink()
    known = {"version": mukca.__version__, "names": sorted(mukca.__all__), "printed": told(folder)}
    (folder / "known.json").write_text(json.dumps(known, indent=1) + "\n")


def told(folder):
    """Return what every command says of the files of a set."""
    with tempfile.TemporaryDirectory() as scratch:
        copy = shutil.copytree(folder, Path(scratch) / "set")
        with inside(copy):
            return {words: printed(words) for words in COMMANDS}


def lost(folder, now=None):
    """Return what the present version no longer says or reads, a line each; it says ``now``."""
    known = json.loads((folder / "known.json").read_text())
    lines = [f"mukca.{name}" for name in known["names"] if not hasattr(mukca, name)]
    calibration = mukca.load_calibration(folder / "calibrated")
    placements = mukca.read_placements(folder / "front", folder / "left", folder / "right")
    lines += [] if calibration.validate(placements) else ["validate"]
    now = now or told(folder)
    for words, before in known["printed"].items():
        if words not in now or (now[words]["status"] == 2) != (before["status"] == 2):
            lines.append(f"{words}: status {before['status']}, now {now.get(words)}")
        else:
            gone = sorted(set(before["keys"]) - set(now[words]["keys"]))
            lines += [f"{words}: {key}" for key in gone]
    return lines


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--write", action="store_true", help="make the set")
    arguments = parser.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if arguments.write:
        write(arguments.folder.resolve())
        sys.exit()
    folders = [arguments.folder] if arguments.folder else sorted(STORED.iterdir())
    gone = [f"{folder.name}: {line}" for folder in folders for line in lost(folder.resolve())]
    sys.stdout.writelines(f"{line}\n" for line in gone or ["nothing is lost"])
    sys.exit(bool(gone))
