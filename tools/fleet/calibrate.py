"""All of one arm: its sessions calibrated one by one, and how each held at the next."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain, combinations
from pathlib import Path
from statistics import fmean, stdev
from typing import Any

from ...errors import MukcaError
from ...recorder import Placement, is_placement, placements_in, read_placement
from ...solver.assessment import LEAST_SAMPLES, stamp_of
from ...solver.calibration import Calibration, SolveOptions, UsageError, calibrate
from ...solver.identification.data import copied_sockets
from ...solver.identification.robot import load_robot
from ...solver.results import agreement
from ..report import build_report
from .document import FleetArm, FleetCheck, FleetCurves, FleetParameter, FleetSession

MODEL = "robot.urdf"
"""An arm's own model, where its folder has one."""
FAILED = ("FAIL", "NO BETTER", "refused")
"""Verdicts on a session whose numbers say nothing of a fleet."""
MEAN = "mean_absolute_error"
"""Name of the limit on the errors of a check."""
AGAIN = "Record 6 more samples in each of two sockets: that decides."
"""Advice where a change is more probable than not, but not sure."""


@dataclass(frozen=True)
class ArmFolder:
    """One arm's recordings, and how to calibrate by them."""

    folder: Path
    """Holds placements, or folders of placements, one a date."""
    out: Path
    """Place of its results."""
    robot: Mapping[str, Any]
    """Arguments of :func:`mukca.load_robot`."""
    settings: SolveOptions
    what_changed: Callable[..., Any]
    """:func:`mukca.what_changed`, by which a drift is told."""
    copied: str | None = None
    """The reason not to calibrate it: its samples are those of another arm, or are there twice."""


def find_arms(folder: Path) -> list[Path]:
    """Return the folders of all arms, by name.

    Raises:
        UsageError: No such folder, or none in it holds a recording.
    """
    if not folder.is_dir():
        raise UsageError(
            f"{folder}: no such folder; a fleet is a folder with one folder an arm"
        )
    if is_placement(folder) or placements_in(folder):
        raise UsageError(
            f"{folder}: holds the placements of one arm; a fleet is a folder with one folder an "
            "arm, as in fleet/arm-7/2026-06-01/front. For one arm there is mukca solve"
        )
    arms = [child for child in _inside(folder) if find_sessions(child)]
    if not arms:
        raise UsageError(f"{folder}: no arm's folder in it holds a recording")
    return arms


def find_sessions(arm: Path) -> dict[str, list[Path]]:
    """Return the placements of one arm by session; those in its own folder come first, as ""."""
    dated = {child.name: child for child in _inside(arm) if not is_placement(child)}
    sessions = {
        name: placements_in(folder) for name, folder in {"": arm, **dated}.items()
    }
    return {name: placements for name, placements in sessions.items() if placements}


def find_copies(arms: Sequence[Path]) -> dict[Path, str]:
    """Return the arms with samples that another arm has too, or they twice, each with its message.

    Of a copied session nobody could tell a drift. A placement that cannot be read stops its arm,
    and no copy of it is found.
    """
    copied: dict[Path, str] = {}
    for first, second in copied_sockets(_readable(arms)):
        for mine, copy in ((second, first), (first, second)):
            arm, whose = [
                next(arm for arm in arms if Path(file).is_relative_to(arm))
                for file in (mine, copy)
            ]
            words = f"arm {whose.name}" if whose != arm else "another of its placements"
            copied.setdefault(
                arm, f"{mine}: the samples are those of {words}: copied? {copy}"
            )
    return copied


def _readable(arms: Sequence[Path]) -> Iterator[Placement]:
    for arm in arms:
        for folder in chain(*find_sessions(arm).values()):
            with suppress(MukcaError):
                yield read_placement(folder)


def _inside(folder: Path) -> list[Path]:
    return sorted(child for child in folder.iterdir() if child.is_dir())


def calibrate_arm(arm: ArmFolder) -> FleetArm:
    """Calibrate one arm by each of its sessions, write the results, and say what is next.

    Each session also checks the calibration that stands, and does nothing else where it is too
    small to calibrate. A calibration stands until a later one passes. An arm that cannot be
    calibrated says why in :attr:`FleetArm.error`, and stops no other.
    """
    checks: list[FleetCheck] = []
    sessions: list[FleetSession] = []
    error = arm.copied
    model = arm.folder / MODEL
    arguments = dict(arm.robot)
    if model.exists():
        arguments["robot"] = str(model)
    try:
        robot = load_robot(**arguments)
        stands: tuple[str, Calibration] | None = None
        for name, folders in find_sessions(arm.folder).items() if error is None else ():
            placements = [read_placement(folder) for folder in folders]
            if stands:
                checks.append(_check(arm, name, *stands, placements))
                # nothing can be left out, or too few samples would be trained on without it
                counts = [len(placement.samples) for placement in placements]
                if sum(counts) - max(counts) < 2 * LEAST_SAMPLES:
                    continue
            calibration = calibrate(robot, placements, **vars(arm.settings))
            session = _session(arm, name, calibration)
            sessions.append(session)
            passed = session.status == "pass" or session.kind == "better"
            if passed or (not stands and not calibration.document.distorted):
                stands = name, calibration.saved_in(arm.out / name)
    except MukcaError as reason:
        error = " ".join(str(reason).split()).replace(f"{arm.folder}/", "")
    return FleetArm(
        name=arm.folder.name,
        robot=arguments["robot"],
        sessions=tuple(sessions),
        checks=tuple(checks),
        error=error,
        again=_next_step(sessions, checks, error),
    )


def _session(arm: ArmFolder, name: str, calibration: Calibration) -> FleetSession:
    document = calibration.document
    saved = calibration if document.distorted else calibration.saved_in(arm.out / name)
    report, files = build_report(saved.assessment)
    outputs: dict[str, str] = {}
    if not document.distorted:
        outputs = calibration.save(arm.out / name, force=True, pages=lambda _: files)
    proof = document.summary.proof
    summary = proof or document.summary.train
    assert summary is not None  # something was trained on
    verdict = report.verdict
    return FleetSession(
        name=name,
        placements=len(document.placements),
        samples=sum(sum(row.samples) for row in document.placements),
        held_out=proof is not None,
        nominal=summary.before.mean_absolute_error,
        calibrated=summary.loaded.mean_absolute_error,
        distance_error=summary.loaded.distance_error,
        status="refused" if document.distorted else verdict.status,
        kind=verdict.kind,
        scope=verdict.scope,
        answer=verdict.answer,
        text=calibration.refusal(accept_distorted=False)
        or f"{verdict.title}: {verdict.text}",
        todo=report.todo[0] if report.todo else None,
        parameters=document.parameters,
        curves=document.curves,
        outputs=outputs,
    )


def _check(
    arm: ArmFolder,
    name: str,
    since: str,
    reference: Calibration,
    placements: Sequence[Placement],
) -> FleetCheck:
    """Return how a calibration does on recordings that were made after it."""
    settings = arm.settings.validated()
    repeatability = (
        None if settings.repeatability_mm is None else settings.repeatability_mm / 1e3
    )
    validity = arm.what_changed(
        reference, placements, distance=settings.distance, repeatability=repeatability
    )
    new = validity.errors.summary.test
    row = next((row for row in validity.verdict.limits if row.name == MEAN), None)
    reason, advice = validity.said
    return FleetCheck(
        session=name,
        since=since,
        samples=sum(len(placement.samples) for placement in placements),
        mean_absolute_error=new and new.loaded.mean_absolute_error,
        limit=row and row.limit,
        status="incomplete" if validity.doubtful else validity.verdict.status,
        kind=validity.verdict.kind,
        changed=validity.drifted,
        change=validity.brief,
        reason=reason,
        advice=AGAIN if validity.doubtful else advice,
    )


def _next_step(
    sessions: Sequence[FleetSession], checks: Sequence[FleetCheck], error: str | None
) -> str | None:
    """Return the next thing to record or to do; None where all is well."""
    if error:
        return f"Mend the recordings: {error}"
    last = sessions[-1]
    check = checks[-1] if checks else None
    if check and check.session != last.name:
        if check.status == "pass":
            return None
        since = f" since {check.since}" if check.since else ""
        return f"{check.change}{since}: {check.advice or check.reason}"
    if last.status == "refused":
        return "Measure the sockets' distance, and check the recordings; then calibrate again"
    if last.status != "pass":
        cause = last.text.partition(": ")[2].partition(". ")[0]
        return f"{last.todo.text if last.todo else 'Look at its report'}. {cause}"
    if check and check.changed:
        old = f"that of {check.since}" if check.since else "the one before"
        urdf = Path(last.outputs["urdf"]).name
        return f"Load the new {urdf} in place of {old}: {check.reason}"
    return None


def last_sessions(arms: Sequence[FleetArm]) -> list[FleetSession]:
    """Return the last session of each arm that did not fail: of those, means are taken."""
    sound = [arm for arm in arms if arm.error is None]
    last = chain(*(arm.sessions[-1:] for arm in sound))
    return [row for row in last if stamp_of(row.status, row.kind) not in FAILED]


def compare_parameters(arms: Sequence[FleetArm]) -> tuple[FleetParameter, ...]:
    """Return each parameter over all arms of a model, by their last calibrations.

    Arms that failed are left out. A mean far from zero is wrong in the model that all share; the
    spread is what each arm has of its own.
    """
    groups: dict[tuple[str, str, str], dict[str, float]] = {}
    for arm in arms:
        robot = MODEL if "/" in arm.robot else arm.robot
        for session in last_sessions([arm]):
            for value in session.parameters:
                key = robot, value.name, value.unit
                groups.setdefault(key, {})[arm.name] = value.change
    return tuple(_parameter(*key, changes) for key, changes in groups.items())


def _parameter(
    robot: str, name: str, unit: str, changes: Mapping[str, float]
) -> FleetParameter:
    """Return a parameter by its change from nominal of each arm."""
    mean = fmean(changes.values())
    # rounded, since two arms are equally far, and rounding errors must not choose between them
    farthest = max(changes, key=lambda arm: round(abs(changes[arm] - mean), 12))
    return FleetParameter(
        robot=robot,
        name=name,
        unit=unit,
        arms=len(changes),
        mean=mean,
        spread=stdev(changes.values()) if len(changes) > 1 else None,
        farthest=farthest,
        change=changes[farthest],
    )


def compare_curves(arms: Sequence[FleetArm]) -> tuple[FleetCurves, ...]:
    """Return how far the error curves of arms of one type agree, by their last calibrations."""
    last = [(arm, arm.sessions[-1]) for arm in arms if arm.sessions]
    curves = [
        (arm, row.curves) for arm, row in last if row.curves and row.status != "refused"
    ]
    pairs = (
        FleetCurves(robot=a.robot, a=a.name, b=b.name, joints=agreement(first, second))
        for (a, first), (b, second) in combinations(curves, 2)
        if a.robot == b.robot
    )
    return tuple(pair for pair in pairs if pair.joints)
