"""Recordings made ready for a fit: checked against the robot, and by a table of checks."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import cast

import numpy as np

from ...errors import MukcaError
from ...recorder import Placement, RecordingError, Sample, distinctly_named
from .. import results
from ..identification.data import (
    Measurement,
    TooFewError,
    as_flange_poses,
    check_distinct,
    measure,
    spaced,
)
from ..identification.robot import Robot, choose_parameters
from ..tables import without
from .fit import CalibrationProblem
from .option import UsageError
from .options import SolveOptions


def checked(
    robot: Robot, placements: Sequence[Placement], options: SolveOptions
) -> tuple[tuple[Measurement, ...], list[MukcaError]]:
    """Return checked placements, and why others are left out, too short or not readable."""
    sockets = 1 if options.method == "auto" else 2
    measured = list[Measurement]()
    errors = list[MukcaError]()
    for recorded in without(placements, options.leave_out):
        placement = at_scale(recorded, options.scale)
        try:
            m = measure(
                placement, robot, options.distance, sockets=sockets, load=options.load
            )
            measured.append(spaced(m, placement.name, options.located))
        except (TooFewError, RecordingError) as error:
            if options.as_recorded:
                raise
            errors.append(error)
    return tuple(measured), errors


def at_scale(placement: Placement, scale: float | None) -> Placement:
    """Return a placement whose measured points are divided by an instrument's scale."""
    if placement.kind != "points" or scale is None:
        return placement
    samples = list[Sample]()
    for sample in placement.samples:
        x, y, z = np.divide(sample.point or np.nan, scale).tolist()
        samples.append(replace(sample, point=(x, y, z)))
    return replace(placement, samples=tuple(samples))


LOCKED = math.radians(6)
"""A pitch nearer than this to 90 degrees leaves roll and yaw hardly two turns."""


def model_warnings(robot: Robot, options: SolveOptions) -> Iterator[str]:
    """Yield what is to be said of a robot's model before its recordings are fitted."""
    if options.free and not options.prior and Path(robot.source).suffix == ".urdf":
        yield from _held_as_exact(robot)
    if options.method == "paper":
        yield from _locked_angles(robot, options)
    elif robot.masses_assumed:
        yield (
            f"{robot.source}: the URDF has no masses, so equal ones are assumed: "
            "stiffnesses are relative, and efforts are not used; there is nothing to do"
        )


def _held_as_exact(robot: Robot) -> Iterator[str]:
    """Yield what a few free numbers of a calibrated URDF cannot know."""
    file = Path(robot.source).with_name("calibration.json")
    try:
        # A URDF with other meshes, or a further link, has the same origins.
        document = results.read(file, results.CalibrationDocument, results.FORMAT)
        calibrated = results.calibrated_robot(document, str(file))
    except results.DocumentError:
        return
    same = robot.joint_names == calibrated.robot.joint_names
    if same and np.array_equal(robot.origins, calibrated.origins):
        yield (
            f"{robot.source}: calibrated, and --free takes the rest of it for exact: neither its "
            "elasticity nor how well it is known is in a URDF. mukca rezero, tool or handeye "
            f"{file} hold it with both; mukca solve --prior {file} fits all of it again"
        )


def _locked_angles(robot: Robot, options: SolveOptions) -> Iterator[str]:
    """Yield a warning of joints whose roll and yaw are nearly one turn, which the paper fits."""
    parameters = choose_parameters(robot, options.free, options.fix)
    variable = {parameter.joint for parameter in parameters if parameter.unit == "rad"}
    joints = [joint for joint in robot.actuated if joint.name in variable]
    near = math.sin(LOCKED)
    locked = [
        joint.name for joint in joints if abs(math.cos(joint.origin.rpy[1])) < near
    ]
    if locked:
        yield (
            f"{', '.join(locked)}: a pitch near 90 degrees makes roll and yaw one turn, and the "
            "third turn is lost to --method paper; --method auto has all three"
        )


def check_zeros(robot: Robot, options: SolveOptions) -> None:
    """Refuse to look for zeros where the URDF could hold none."""
    parameters = choose_parameters(robot, options.free, options.fix)
    angles = Counter(
        parameter.joint for parameter in parameters if parameter.unit == "rad"
    )
    turning = [joint for joint in robot.actuated if joint.type != "prismatic"]
    if options.zeros and not any(angles[joint.name] == 3 for joint in turning):
        raise UsageError("--zeros: a joint must turn, and its angles be free")


Recordings = (
    Placement | Sequence[Placement] | Mapping[str, Placement | Sequence[Placement]]
)
"""Placements; of several robots by the robots' names, or each with its own ``robot_name``."""

Check = Callable[[CalibrationProblem], CalibrationProblem]
"""A look at measurements before their fit: it adds findings, or returns other measurements."""


def problem_of(
    robot: Robot,
    train: Recordings,
    test: Recordings,
    options: SolveOptions,
    checks: Sequence[Check],
    name: str = "",
) -> CalibrationProblem:
    """Return what there is to fit to one robot, once each check has looked at it."""
    if isinstance(train, Mapping) or isinstance(test, Mapping):
        raise UsageError("placements by the names of robots need robots by name, too")
    training = as_list(train)
    held_out = as_list(test)
    if not name:
        options.check_names(distinctly_named([*training, *held_out]))
    if not isinstance(robot, Robot):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise UsageError(f"{robot!r:.60}: no robot; load it by mukca.load_robot")
    check_zeros(robot, options)
    problem = _measured(robot, training, held_out, options)
    problem = replace(problem, name=name)
    for check in checks:
        problem = check(problem)
    return problem


def _measured(
    robot: Robot, train: list[Placement], test: list[Placement], options: SolveOptions
) -> CalibrationProblem:
    """Return the checked placements to train and to test on, and what to warn of."""
    if not train:
        raise UsageError("no placement to train on; read some by mukca.read_placements")
    distinct = options.payloads.carried_by(distinctly_named([*train, *test]))
    if options.flange_poses:
        distinct = as_flange_poses(distinct)
    train, test = distinct[: len(train)], distinct[len(train) :]
    paths = {p.path.resolve() for p in train if p.path is not None}
    trained_on = [p for p in test if p.path is not None and p.path.resolve() in paths]
    warnings = [f"{p.path}: trained on, so left out of the test" for p in trained_on]
    measured = [placement for placement in distinct if placement.kind == "points"]
    if measured and options.method == "paper":
        raise UsageError(
            f"{measured[0].where}: measured points; --method paper knows sockets only, "
            "--method auto knows both"
        )
    training, errors = checked(robot, train, options)
    held_out, errors_held_out = checked(
        robot, [p for p in test if p not in trained_on], options
    )
    if not training:
        raise next(
            iter(errors), UsageError("--leave-out: no placement is left to train on")
        )
    warnings += [f"{error}; it is left out" for error in (*errors, *errors_held_out)]
    data = (*training, *held_out)
    check_distinct(data)
    warnings += model_warnings(robot, options)
    warnings += chain.from_iterable(m.warnings for m in data)
    return CalibrationProblem(
        robot,
        training,
        options.load,
        options=options,
        test=held_out,
        warnings=tuple(warnings),
    )


def as_list(placements: object) -> list[Placement]:
    """Return placements as a list; one stands for itself, and a path is refused."""
    several = isinstance(placements, Iterable) and not isinstance(placements, str)
    items: list[object] = (
        list(cast("Iterable[object]", placements)) if several else [placements]
    )
    checked_items: list[Placement] = []
    for item in items:
        if not isinstance(item, Placement):
            raise UsageError(
                f"{item!r:.60}: no placement; read it by mukca.read_placements"
            )
        checked_items.append(item)
    return checked_items
