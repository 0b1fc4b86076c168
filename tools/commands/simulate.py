"""``mukca simulate``: a peg insertion in simulation, with the model under test."""

import argparse
from typing import TYPE_CHECKING, Any

from ... import MukcaError
from ..arguments import UsageError
from ..terminal import Terminal
from .demo import DEMO_SEED, demo_arm

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ..experiments.insertion import Trial

EXAMPLE = """example:
  mukca simulate insertion --model nominal --hole-mm 16
  mukca simulate insertion --model calibrated --hole-mm 10.4 --trials 20

The arm moves by its true kinematics; its controller, Cartesian impedance control, knows only the
model that it is given: nominal, calibrated (from recordings of this arm, made now), true, or the
file of a calibrated URDF of this arm. The goal is taught once, elbow up, in a tight hole; each
trial starts with the elbow elsewhere. Needs the extra: pip install 'mukca[simulation]'"""


class MissingExtra(MukcaError):  # noqa: N818 (the situation's name)
    """A package of the extra ``simulation`` is not installed."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    parser.add_argument("experiment", choices=("insertion",))
    parser.add_argument(
        "--model", default="calibrated", help="nominal, calibrated, true, or a URDF file"
    )
    parser.add_argument(
        "--hole-mm", type=float, default=10.4, metavar="MM", help="its diameter; the peg has 10 mm"
    )
    parser.add_argument("--trials", type=int, default=20, metavar="N", help="(default: 20)")
    parser.add_argument(
        "--cross",
        type=int,
        default=0,
        metavar="N",
        help="then at N positions of an X of 25 mm steps, 24 at most (default: 0)",
    )
    parser.add_argument("--arm", type=int, default=DEMO_SEED, metavar="SEED", help="which true arm")
    parser.add_argument("--seed", type=int, default=0, help="of recordings, teaching and starts")
    parser.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Run the trials, and show how many went in."""
    if not 10.1 <= arguments.hole_mm <= 40:
        raise UsageError(f"--hole-mm {arguments.hole_mm}: give 10.1 to 40; the peg has 10 mm")
    if arguments.trials < 1 or not 0 <= arguments.cross <= 24:
        raise UsageError("--trials is at least 1, --cross 0 to 24")
    try:
        from ..experiments.cell import build_cell
        from ..experiments.insertion import insert_at_centre, insert_on_cross
        from ..experiments.models import model_urdf
    except ImportError as error:
        raise MissingExtra(
            f"{error.name} is not installed; install the extra: pip install 'mukca[simulation]'"
        ) from None
    nominal, arm = demo_arm(arguments.arm)
    urdf = model_urdf(arguments.model, nominal, arm, arguments.seed)
    cell = build_cell(arm, urdf, arguments.hole_mm / 1e3)
    trials = {"centre": figures(insert_at_centre(cell, arguments.trials, arguments.seed))}
    if arguments.cross:
        trials["cross"] = figures(insert_on_cross(cell, arguments.cross, arguments.seed))
    for place, found in trials.items():
        terminal.say(spoken(place, arguments, found))
    if arguments.json:
        settings = {key: getattr(arguments, key) for key in ("model", "arm", "seed")}
        terminal.emit({**settings, "hole": arguments.hole_mm / 1e3, **trials})
    return 0


def figures(trials: "Iterable[Trial]") -> dict[str, Any]:
    """Return how many went in, how far off they were above the hole, and what forces arose."""
    done = list(trials)
    forces = [trial.forces for trial in done]
    return {
        "inserted": sum(trial.inserted for trial in done),
        "trials": len(done),
        "tracking_error": sum(trial.tracking_error for trial in done) / len(done),
        "max_tracking_error": max(trial.tracking_error for trial in done),
        "force": {
            "mean": float(sum(f.mean() for f in forces) / len(forces)),
            "min": float(min(f.min() for f in forces)),
            "max": float(max(f.max() for f in forces)),
        },
    }


def spoken(place: str, arguments: argparse.Namespace, found: dict[str, Any]) -> str:
    """Return a line for people."""
    return (
        f"{arguments.model}, {place}: {found['inserted']} of {found['trials']} into "
        f"{arguments.hole_mm} mm; above the hole off by {1e3 * found['tracking_error']:.2f} mm on "
        f"average, {1e3 * found['max_tracking_error']:.2f} mm at most; contact force "
        f"{found['force']['mean']:.1f} N on average, {found['force']['max']:.1f} N at most"
    )
