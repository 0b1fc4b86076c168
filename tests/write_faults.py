"""A calibration is saved over an older one while the disk fails, once at each call in each way.

``python write_faults.py OLD FOLDER`` prints a line of JSON for each fault. Folders with the same
contents are kept once, in FOLDER.
"""

import errno
import hashlib
import json
import os
import shutil
import sys
from pathlib import Path

from msgspec.structs import replace

import mukca
from mukca.solver.calibration import Calibration
from mukca.tools.report import report_files

STORED = Path(__file__).parent / "stored" / "1.0" / "calibrated"
CALLS = ((os, "open"), (os, "write"), (os, "fsync"), (os, "close"), (Path, "replace"))
KINDS = ("kill", "ENOSPC", "EIO", "EROFS")
KILLED, REFUSED = 9, 2


def another():
    """The stored calibration with one origin 1 mm away, and pages that were made of it."""
    document = mukca.load_calibration(STORED).document
    first, *others = document.parameters
    moved = replace(first, calibrated=first.calibrated + 1e-3, exported=first.exported + 1e-3)
    calibration = Calibration(replace(document, parameters=(moved, *others)))
    pages = report_files(calibration)
    return lambda folder: calibration.save(folder, force=True, pages=lambda _: pages)


def break_call(number, kind):
    """From now on let one call of this process fail, counted from 1; return the calls' names."""
    names = []

    def broken(name, call):
        def counted(*arguments, **options):
            names.append(name)
            if len(names) == number and kind == "kill":
                os._exit(KILLED)
            if len(names) == number:
                if name == "close":
                    call(*arguments)
                raise OSError(getattr(errno, kind), os.strerror(getattr(errno, kind)))
            # No power is lost here, so that nothing need wait for the disk.
            return None if name == "fsync" else call(*arguments, **options)

        return counted

    for holder, name in CALLS:
        setattr(holder, name, broken(name, getattr(holder, name)))
    return names


def attempt(write, folder, number, kind):
    """Write in a process of its own; return the last call's name, the status, and what was said."""
    reader, writer = os.pipe()
    if os.fork() == 0:
        said, status = "", 0
        names = break_call(number, kind)
        try:
            write(folder)
        except mukca.MukcaError as error:
            said, status = str(error), REFUSED
        if len(names) < number:
            status = 1  # there is no such call
        with os.fdopen(writer, "w") as stream:
            stream.write(said)
        os._exit(status)
    os.close(writer)
    with os.fdopen(reader) as stream:
        said = stream.read()
    return os.waitstatus_to_exitcode(os.wait()[1]), said


def contents(folder):
    """The digest of each file by name, but of those that nobody reads."""
    files = sorted(file for file in folder.iterdir() if not file.name.startswith("."))
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}


def main(old, folder):
    write = another()
    place, new = folder / "out", folder / "new"
    shutil.copytree(old, place)
    write(place)
    place.rename(new)
    before, after = contents(old), contents(new)
    number, status = 0, 0
    while status != 1:
        number += 1
        for kind in KINDS:
            shutil.copytree(old, place)
            status, said = attempt(write, place, number, kind)
            now = contents(place)
            beside = [file.name for file in place.iterdir() if file.name.startswith(".")]
            key = hashlib.sha256(json.dumps(now).encode()).hexdigest()[:8]
            kept = folder / key
            if kept.exists():
                shutil.rmtree(place)
            else:
                place.rename(kept)
            fresh = [name for name in now if now[name] == after[name] != before.get(name)]
            same = [name for name in now if now[name] == before.get(name)]
            row = {"number": number, "kind": kind, "status": status, "said": said}
            row |= {"folder": key, "new": fresh, "old": same, "beside": beside}
            row["mixed"] = now not in (before, after)
            if status != 1:
                print(json.dumps(row))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
