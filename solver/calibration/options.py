"""Options of a calibration: the one definition of each; a new one is one more field."""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from ..bayes.model.effects import EXTENSIONS
from .option import Method, Option, UsageError

if TYPE_CHECKING:
    from ..data import KnownDistance, Load, SocketAt
else:  # the command line reads the types of the fields, and has words for these
    KnownDistance = SocketAt = str

Optimizer = Literal["gauss-newton", "ipopt"]


_NAMES = "joint names, JOINT.x .. JOINT.yaw, JOINT.xyz or JOINT.rpy; * stands for any text"


@dataclass(frozen=True, kw_only=True)
class SolveOptions:
    """Options of a calibration. None, or an empty sequence, stands for the default."""

    method: Annotated[
        Method,
        Option(
            "auto: geometry, elasticity and transmission error, as far as the data support them; "
            "paper: Eq. (5), geometry alone"
        ),
    ] = "auto"
    distance: Annotated[
        float | None,
        Option(
            "distance of the sockets' centres in metres (default: the recording's, or 0.05); "
            "1 mm wrong makes the arm 2 % too long",
            metavar="M",
        ),
    ] = None
    free: Annotated[Sequence[str], Option(f"free parameters: {_NAMES}", metavar="P")] = ()
    fix: Annotated[Sequence[str], Option("fixed parameters, likewise", metavar="P")] = ()
    split_moved: Annotated[
        bool, Option("where a base moved, give the part after it a socket of its own")
    ] = False
    flange_poses: Annotated[
        bool, Option("each poses.csv holds measured flange poses, whatever its first line lacks")
    ] = False
    repeatability_mm: Annotated[
        float | None,
        Option(
            "repeatability of the arm in millimetres, from its data sheet, on which the verdict's "
            "limits rest (default: what is known of the arm)",
            metavar="MM",
            unit="millimetres",
            allowed=lambda value: 0 < value < 1e4,
        ),
    ] = None
    accept_distorted: Annotated[
        bool, Option("export even a model that does not reproduce the sockets' distance")
    ] = False
    known: Annotated[
        Sequence[str | Path | KnownDistance],
        Option(
            "further measured distances between sockets, to which the fit keeps as closely as "
            "their standard deviation S says; or a file with one a line",
            metavar="A:0-B:0=M[+-S]",
            method="auto",
            default=(),
        ),
    ] = ()
    sockets_at: Annotated[
        str | Path | Sequence[str | Path | SocketAt],
        Option(
            "measured coordinates of sockets, a CSV file with the columns frame, socket, x [mm], "
            "y [mm], z [mm], deviation [mm]; the frame `base` is the robot's own",
            metavar="FILE",
            method="auto",
            default=(),
        ),
    ] = ()
    distance_deviation: Annotated[
        float | None,
        Option(
            "standard deviation of the distance in metres; the default is a caliper's",
            metavar="M",
            method="auto",
            default=3e-5,
            unit="metres",
            allowed=lambda value: 0 < value < 1,
        ),
    ] = None
    without: Annotated[
        Sequence[str],
        Option(
            "effects that are not to be tried",
            method="auto",
            default=(),
            choices=(*EXTENSIONS, "joint-noise"),
        ),
    ] = ()
    zeros: Annotated[
        bool | None,
        Option(
            "the joints' zeros may be off by degrees: for arms made of servos",
            method="auto",
            default=False,
        ),
    ] = None
    type_prior: Annotated[
        Sequence[str | Path],
        Option(
            "calibration.json of other arms of the type, or a fleet's elasticity.json: their "
            "elasticity is much the same in this one; the data decide how far to believe it "
            "(default: shipped, from measurements of other arms, so far of Pandas; none: nothing)",
            metavar="FILE",
            method="auto",
            default=("shipped",),
        ),
    ] = ()
    prior: Annotated[
        str | Path | None,
        Option(
            "an earlier calibration.json of this very arm: what it knows of geometry, elasticity "
            "and error curves, and how well, is where this one begins",
            metavar="CALIBRATION",
            method="auto",
        ),
    ] = None
    remounted: Annotated[
        Sequence[str],
        Option(
            "what was taken off and put back since that calibration",
            method="auto",
            default=(),
            choices=("tool", "base"),
        ),
    ] = ()
    payload: Annotated[
        float | None,
        Option(
            "mass at the ball beyond the model's, in kilograms",
            metavar="KG",
            method="auto",
            unit="kilograms, zero or more",
            allowed=lambda value: 0 <= value < 1000,
        ),
    ] = None
    gravity: Annotated[
        Sequence[float] | None,
        Option(
            "acceleration in the base frame in m/s^2, for an arm on a wall or ceiling",
            metavar=("X", "Y", "Z"),
            method="auto",
            unit="its three components in m/s^2, for an arm that hangs from the ceiling 0 0 9.81",
            allowed=lambda value: len(value) == 3 and 9 < math.hypot(*value) < 11,
        ),
    ] = None
    optimizer: Annotated[
        Optimizer | None,
        Option(
            "both reach the same minimum; ipopt is the paper's",
            method="paper",
            default="gauss-newton",
        ),
    ] = None
    regularization: Annotated[
        float | None, Option("lambda of Eq. (5)", metavar="L", method="paper", default=1e-4)
    ] = None
    max_iterations: Annotated[
        int | None,
        Option(
            "steps allowed",
            metavar="N",
            method="paper",
            default=200,
            unit="at least 1",
            allowed=lambda value: value >= 1,
        ),
    ] = None

    def validated(self) -> "SolveOptions":
        """Return the options with defaults filled in, and files read; refuse what cannot be."""
        if self.method not in get_args(Method):
            raise UsageError(f"method {self.method!r}: choose one of {', '.join(get_args(Method))}")
        filled: dict[str, Any] = {}
        for name, option in option_table().items():
            value = getattr(self, name)
            mine = option.method in (None, self.method)
            if value is None or (isinstance(value, Sequence) and not value):
                filled[name] = value if option.default is None or not mine else option.default
            elif not mine:
                words = f"--{name.replace('_', '-')} belongs to --method {option.method}"
                raise UsageError(f"{words}; this is --method {self.method}")
            else:
                option.check(name, value)
        if self.remounted and self.prior is None:
            raise UsageError("--remounted: since which calibration? Name it by --prior")
        return replace(self, **filled)._read()

    def _read(self) -> "SolveOptions":
        """Return the options with files of measured places replaced by their content."""
        from ..data import read_known

        return replace(
            self,
            known=tuple(read_known(self.known)),
            sockets_at=tuple(self.located),
            type_prior=tuple(map(str, self.type_prior)),
            prior=None if self.prior is None else str(self.prior),
        )

    @property
    def load(self) -> "Load":
        """Gravity and payload, which pull at the joints."""
        from ..data import STANDARD_LOAD, Load

        x, y, z = STANDARD_LOAD.gravity if self.gravity is None else self.gravity
        return Load((x, y, z), self.payload or 0.0)

    @property
    def distances(self) -> "list[KnownDistance]":
        """Known distances."""
        from ..data import parse_known

        return [parse_known(str(k)) if isinstance(k, str | Path) else k for k in self.known]

    @property
    def located(self) -> "list[SocketAt]":
        """Known coordinates of sockets."""
        from ..data import read_sockets_at

        return read_sockets_at(self.sockets_at)

    @property
    def deviation(self) -> float:
        """Standard deviation of the distance between a base's sockets [m]."""
        return self.distance_deviation or option_table()["distance_deviation"].default

    def as_dict(self) -> dict[str, Any]:
        """Return the options of this method by name, as they stand in ``calibration.json``."""
        return {
            name: _plain(getattr(self, name))
            for name, option in option_table().items()
            if name != "method" and option.method in (None, self.method)
        }


def option_table() -> dict[str, Option]:
    """Return the documentation of each option by its name."""
    return {field.name: field.type.__metadata__[0] for field in fields(SolveOptions)}  # pyright: ignore


def check_keywords(function: str, given: Collection[str], known: Collection[str]) -> None:
    """Refuse a keyword that a function does not have, and name the nearest that it has."""
    from difflib import get_close_matches

    for name in given:
        if name not in known:
            (near,) = get_close_matches(name, known, n=1, cutoff=0.0)
            raise UsageError(f"{function} has no option {name!r}; the nearest is {near!r}")


def _plain(value: Any) -> Any:
    if isinstance(value, tuple | list):
        return [one if isinstance(one, float | int) else str(one) for one in value]  # pyright: ignore
    return value
