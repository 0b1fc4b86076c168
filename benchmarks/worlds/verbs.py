"""Verbs of the command line over awkward recordings: how each ended, and what was wrong."""

import contextlib
import io
import json
import math
import signal
import traceback
from collections.abc import Container, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mukca.recorder import Placement, hole_files
from mukca.solver.results import write_files
from mukca.tools.cli import main

from .zoo import Recorded

VERBS = ("check", "solve", "paper", "validate", "report", "export", "rezero")
QUATERNION = ("qx", "qy", "qz", "qw")
STATUSES = (0, 1, 2, 3)
"""Done, misses its limits, refused, and not enough data; any other is a defect."""
AS_FOUND = {"found_deviation"}
"""What samples scatter, and not what the fit states: equal rows do not scatter."""
LONGEST = 120
"""By then a verb hangs [s]."""


@dataclass
class Outcome:
    """How verbs ended, and what may not be."""

    statuses: dict[str, int] = field(default_factory=dict[str, int])
    """Exit status of each verb that ran."""
    said: dict[str, str] = field(default_factory=dict[str, str])
    """What each wrote: JSON, or why it refused."""
    faults: list[str] = field(default_factory=list[str])
    """A line each: another exception, a hang, or a deviation that is none."""

    def run(self, verb: str, *words: object, name: str = "") -> int:
        """Run a verb in this process, and keep what came of it, by its name or another one."""
        name, out, err = name or verb, io.StringIO(), io.StringIO()
        status = 70
        try:
            with (
                _limited(),
                contextlib.redirect_stdout(out),
                contextlib.redirect_stderr(err),
            ):
                status = main([verb, *map(str, words), "--json"])
        except SystemExit as stop:  # argparse's own refusals
            status = int(stop.code or 0)
        except Exception as error:
            (*_, last) = traceback.extract_tb(error.__traceback__)
            place = f"{Path(last.filename).name}:{last.lineno} {last.name}"
            self.faults.append(f"{name}: {type(error).__name__}: {error} ({place})")
        else:
            if status not in STATUSES:
                self.faults.append(f"{name}: status {status}: {err.getvalue()}")
        self.statuses[name], self.said[name] = status, out.getvalue() or err.getvalue()
        if status in (0, 1, 3) and out.getvalue():
            found = json.loads(out.getvalue())
            self.faults += [f"{name}: {line}" for line in unsound_deviations(found)]
        return status


@contextlib.contextmanager
def _limited() -> Iterator[None]:
    """Raise a TimeoutError where something hangs."""

    def stop(*_: object) -> None:
        raise TimeoutError(f"no end after {LONGEST} s of processor time")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def unsound_deviations(value: Any, path: str = "") -> Iterator[str]:
    """Yield where a stated deviation is not finite and positive, a line each."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in items:
        own = f"{path}.{key}"
        if isinstance(inner, dict | list):
            yield from unsound_deviations(inner, own)
        elif isinstance(inner, float | int) and not isinstance(inner, bool):
            stated = "deviation" in own and key not in AS_FOUND
            if not math.isfinite(inner) or (stated and not inner > 0):
                yield f"{own} is {inner}"


def walked(recorded: Recorded, folder: Path, verbs: Container[str] = VERBS) -> Outcome:
    """Take recordings through the verbs, and return how each ended.

    What the verbs read and write is below the folder. A calibration that was refused is followed by
    ``rezero`` alone, which needs none.
    """
    outcome, out = Outcome(), folder / "out"
    train, test = (
        _written(recorded, part, folder / part) for part in ("train", "test")
    )
    placements = [p for own in recorded.train.values() for p in own]
    seated = placements[0].samples[0].point is None
    single = "" in recorded.robots
    told = ["--distance", 0.05] if seated else []
    robots = [f"{arm}={robot}".lstrip("=") for arm, robot in recorded.robots.items()]
    models = [
        *(word for robot in robots for word in ("--robot", robot)),
        *recorded.ball,
    ]
    solve = [*train, "--test", *test, *models, *told]
    if single and "check" in verbs:
        outcome.run("check", *train, *test, *models, *told)
    outcome.run("solve", *solve, "--accept-distorted", "--out", out)
    if outcome.statuses.get("check") == 0 and outcome.statuses["solve"] == 2:
        outcome.faults.append(
            f"check passes what solve refuses: {outcome.said['solve']}"
        )
    if single and seated and "paper" in verbs:
        outcome.run("solve", *solve, "--method", "paper", name="paper")
    solved = (out / "calibrated.urdf").exists() or (out / "arms.json").exists()
    if solved and "validate" in verbs:
        outcome.run("validate", out, *test, *told)
    if solved and "report" in verbs:
        outcome.run("report", out, "--force")
    if solved and "export" in verbs:
        outcome.run("export", out, "--to", "mdh", "--out", folder / "mdh.csv")
        outcome.run(
            "export", out, "--to", "c", "--out", folder / "arm.c", name="export to C"
        )
    if single and "rezero" in verbs:
        outcome.run("rezero", out if solved else robots[0], *test, *told)
    return outcome


def _written(recorded: Recorded, part: str, folder: Path) -> list[str]:
    """Write recordings as people have them, and return how the command line names them."""
    words: list[str] = []
    for arm, placements in getattr(recorded, part).items():
        for placement in placements:
            own = folder / arm / placement.place
            write_files(own, _files(placement))
            words.append(f"{arm}:{own}".lstrip(":"))
    return words


def _files(placement: Placement) -> dict[str, bytes]:
    if placement.samples[0].point is None:
        return hole_files(placement)
    turned = placement.samples[0].orientation is not None
    columns = [*(placement.joint_names or ()), *"xyz", *(QUATERNION if turned else ())]
    rows = [
        (*s.position, *(s.point or ()), *(s.orientation or ()))
        for s in placement.samples
    ]
    lines = ["# measured flange poses", ",".join(columns)]
    lines += [",".join(map(repr, row)) for row in rows]
    text = "\n".join(lines if turned else lines[1:]) + "\n"
    return {"poses.csv" if turned else "points.csv": text.encode()}
