"""Options of a calibration: a new one is one more field of both classes."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict, cast, get_args

from .. import tables
from ..identification import data
from ..identification.effects import EXTENSIONS
from .option import Method, Option, Payloads, UsageError

if TYPE_CHECKING:
    from ...recorder import Placement
    from ..identification.data import KnownDistance, Load, SocketAt
else:  # the command line reads the types of the fields, and has words for these
    KnownDistance = SocketAt = str

Optimizer = Literal["gauss-newton", "ipopt"]


class CalibrateOptions(TypedDict, total=False):
    """Keywords of :func:`calibrate`: the fields of :class:`SolveOptions`, which explains them."""

    method: Method
    distance: float | Sequence[float] | None
    free: Sequence[str]
    fix: Sequence[str]
    as_recorded: bool
    leave_out: Sequence[str]
    flange_poses: bool
    repeatability_mm: float | None
    accept_distorted: bool
    no_proof: bool
    scale: float | None
    known: Sequence[str | Path | KnownDistance]
    sockets_at: str | Path | Sequence[str | Path | SocketAt]
    distance_deviation: float | None
    without: Sequence[str]
    zeros: bool | None
    prior: str | Path | None
    remounted: Sequence[str]
    payload: float | str | Sequence[float | str] | None
    gravity: Sequence[float] | None
    optimizer: Optimizer | None
    regularization: float | None
    max_iterations: int | None


def _option(
    text: str,
    metavar: str | tuple[str, ...] | None = None,
    unset: Any = None,
    **about: Any,
) -> Any:
    """Field of an option, with the text of its help and what else :class:`Option` holds."""
    metadata = {"text": text, "metavar": metavar, "group": "fit"}
    return field(default=unset, metadata=metadata | about)


_auto = partial(_option, group="method auto")
_paper = partial(_option, group="method paper")


@dataclass(frozen=True, kw_only=True)
class SolveOptions:
    """Options of a calibration. None, or an empty sequence, stands for the default."""

    method: Method = _option(
        "auto: geometry, elasticity and transmission error, as far as the data support them; "
        "paper: Eq. (5), geometry alone",
        unset="auto",
    )
    distance: float | Sequence[float] | None = _option(
        "distance of the sockets' centres in metres, or with its unit as in 100.1mm (default: the "
        "recording's, or 0.05); 1 mm wrong in 50 makes the arm 2 % too long; measure twice, and "
        "give both",
        "M",
        repeated=True,
    )
    free: Sequence[str] = _option(
        "free parameters: joint names, JOINT.x .. JOINT.yaw, JOINT.xyz or JOINT.rpy; * stands for "
        "any text",
        "P",
        unset=(),
    )
    fix: Sequence[str] = _option("fixed parameters, likewise", "P", unset=())
    as_recorded: bool = _option(
        "take all as it is: nothing differs between places, no samples are of another socket, no "
        "placements are empty; method paper sets nothing right",
        unset=False,
    )
    leave_out: Sequence[str] = _option(
        "leave out a placement, a socket of it, or samples by the numbers that the screen and "
        "`check` name, as in left:1:3,5-7",
        "PLACEMENT[:SOCKET[:SAMPLES]]",
        unset=(),
    )
    flange_poses: bool = _option(
        "each poses.csv holds measured flange poses, whatever its first line lacks",
        unset=False,
    )
    repeatability_mm: float | None = _option(
        "repeatability of the arm in millimetres, from its data sheet, on which the verdict's "
        "limits rest (default: what is known of the arm)",
        "MM",
        within=(1e-9, 1e4),
        unit="millimetres",
    )
    accept_distorted: bool = _option(
        "export even a model that does not reproduce the sockets' distance", unset=False
    )
    no_proof: bool = _option(
        "leave nothing out: without --test nothing then proves the fit", unset=False
    )
    scale: float | None = _auto(
        "measured points are divided by it: 1.01 for an instrument whose lengths come out 1 % too "
        "long, 1 for one that was checked against a known length",
        "S",
        within=(0.5, 2.0),
        unit="a factor near 1",
    )
    known: Sequence[str | Path | KnownDistance] = _auto(
        "further measured distances between sockets, to which the fit keeps as closely as their "
        "standard deviation S says; or a file with one a line, or a table with from, to, "
        "distance [mm], deviation [mm]",
        "A:0-B:0=M[+-S]",
        unset=(),
    )
    sockets_at: str | Path | Sequence[str | Path | SocketAt] = _auto(
        "measured coordinates of sockets, a CSV file with the columns frame, socket, x [mm], "
        "y [mm], z [mm], deviation [mm]; the frame `base` is the robot's own",
        "FILE",
        unset=(),
    )
    distance_deviation: float | None = _auto(
        "standard deviation of the distance in metres; the default is a caliper's",
        "M",
        default=3e-5,
        within=(1e-12, 1.0),
        unit="metres",
    )
    without: Sequence[str] = _auto(
        "effects that are not to be tried",
        unset=(),
        choices=(*EXTENSIONS, "joint-noise"),
    )
    zeros: bool | None = _auto(
        "the joints' zeros may be off by degrees: for arms made of servos; but of joints that "
        "slide, or whose angles --fix holds",
        default=False,
    )
    prior: str | Path | None = _auto(
        "an earlier calibration.json of this very arm: what it knows of geometry, elasticity and "
        "error curves, and how well, is where this one begins",
        "CALIBRATION",
    )
    remounted: Sequence[str] = _auto(
        "what was taken off and put back since that calibration",
        unset=(),
        choices=("tool", "base"),
    )
    payload: float | str | Sequence[str | float] | None = _auto(
        "mass at the ball beyond the model's, in kilograms; PLACEMENT=KG for one placement, as "
        "often as needed",
        "KG",
        repeated=True,
    )
    gravity: Sequence[float] | None = _auto(
        "acceleration in the base frame in m/s^2, for an arm on a wall or ceiling",
        ("X", "Y", "Z"),
        within=(9.0, 11.0),
        unit="its three components in m/s^2, for an arm that hangs from the ceiling 0 0 9.81",
    )
    optimizer: Optimizer | None = _paper(
        "both reach the same minimum; ipopt is the paper's", default="gauss-newton"
    )
    regularization: float | None = _paper("lambda of Eq. (5)", "L", default=1e-4)
    max_iterations: int | None = _paper(
        "steps allowed", "N", default=200, within=(1, 10**9), unit="at least 1"
    )

    def validated(self) -> "SolveOptions":
        """Return the options with defaults filled in, and files read; refuse what cannot be."""
        if self.method not in get_args(Method):
            raise UsageError(
                f"method {self.method!r}: choose one of {', '.join(get_args(Method))}"
            )
        filled: dict[str, Any] = {}
        for name, option in option_table().items():
            value = getattr(self, name)
            unset = getattr(SolveOptions, name)
            mine = option.method in (None, self.method)
            if value is None or (isinstance(value, Sequence) and not value):
                filled[name] = (
                    value if option.default is None or not mine else option.default
                )
                continue
            if not mine:
                words = (
                    f"--{name.replace('_', '-')} belongs to --method {option.method}"
                )
                raise UsageError(f"{words}; this is --method {self.method}")
            filled[name] = (
                (value,) if unset == () and isinstance(value, str | Path) else value
            )
            option.check(name, filled[name])
        if self.remounted and self.prior is None:
            raise UsageError("--remounted: since which calibration? Name it by --prior")
        readings: Any = filled["distance"]
        if (
            isinstance(readings, list | tuple)
            and len(cast("Sequence[Any]", readings)) == 1
        ):
            (filled["distance"],) = readings
        options = replace(self, **filled)
        return replace(
            options,
            known=tuple(tables.read_known(options.known)),
            sockets_at=tuple(options.located),
            payload=options.payloads.words,
            prior=None if options.prior is None else str(options.prior),
        )

    @property
    def payloads(self) -> Payloads:
        """Masses at the ball of all placements."""
        return Payloads.read(self.payload)

    def check_names(self, placements: "Sequence[Placement]") -> None:
        """Refuse options that name a placement, socket or sample which is not there."""
        tables.check_left_out(placements, self.leave_out)
        self.payloads.check(placements)

    @property
    def load(self) -> "Load":
        """Gravity and payload, which pull at the joints."""
        x, y, z = data.STANDARD_LOAD.gravity if self.gravity is None else self.gravity
        return data.Load((x, y, z), self.payloads.of_others)

    @property
    def distances(self) -> "list[KnownDistance]":
        """Known distances."""
        return [
            tables.parse_known(str(k)) if isinstance(k, str | Path) else k
            for k in self.known
        ]

    @property
    def located(self) -> "list[SocketAt]":
        """Known coordinates of sockets."""
        return tables.read_sockets_at(self.sockets_at)

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
    return {entry.name: Option(**entry.metadata) for entry in fields(SolveOptions)}


def check_keywords(
    function: str, names: Collection[str], choices: Collection[str]
) -> None:
    """Refuse a keyword that a function does not have, and name the nearest that it has."""
    from difflib import get_close_matches

    for name in names:
        if name not in choices:
            (nearest,) = get_close_matches(name, choices, n=1, cutoff=0.0)
            raise UsageError(
                f"{function} has no option {name!r}; the nearest is {nearest!r}"
            )


def _plain(value: Any) -> Any:
    if isinstance(value, tuple | list):
        return [item if isinstance(item, float | int) else str(item) for item in value]  # pyright: ignore
    return value
