"""Checks of recordings before a fit, which add findings or set the recordings right."""

from collections.abc import Sequence
from dataclasses import replace

from ...recorder import Placement
from ..diagnostics import next_placement, single_socket_diagnostics
from ..identification.data import measure
from ..identification.robot import Robot
from ..results import Diagnostic, NextPlacement
from .inspected_problem import InspectedProblem
from .options import SolveOptions
from .problem import CalibrationProblem
from .setting_right import mended
from .target_alignment import aligned, as_recorded


def inspected(problem: CalibrationProblem) -> InspectedProblem:
    """Return recordings set right, with all findings on them, and where to record next."""
    view, originals = aligned(problem)
    view, done = mended(view)
    problem = replace(
        view,
        measurements=tuple(as_recorded(m, originals) for m in view.measurements),
        test=tuple(as_recorded(m, originals) for m in view.test),
    )
    place = None
    if any(measured.kind == "sockets" for _, measured in problem.placements):
        text = next_placement(problem.robot, problem.survey)
        place = NextPlacement(text=text)
    checks = (*done, *problem.survey.diagnostics)
    return replace(problem, checks=checks, next_placement=place)


def lone_sockets(problem: CalibrationProblem) -> CalibrationProblem:
    """Return recordings of one robot with findings on placements in one socket only."""
    if problem.name or problem.options.located:
        return problem
    measurements = [measured for _, measured in problem.placements]
    diagnostics = single_socket_diagnostics(measurements, problem.options.distances)
    return replace(problem, checks=(*problem.checks, *diagnostics))


def placements_set_right(
    robot: Robot, placements: Sequence[Placement], options: SolveOptions
) -> tuple[list[Placement], list[Diagnostic]]:
    """Return placements with all set right that can be, as before a fit, and what was done."""
    measured = [
        measure(p, robot, options.distance, sockets=1, load=options.load)
        for p in placements
    ]
    problem = CalibrationProblem(
        robot, (), options.load, options=options, test=measured
    )
    mending, done = mended(problem)
    return [m.placement for m in mending.test], done
