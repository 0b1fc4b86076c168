"""Options of a calibration: a new one is one more field of both classes, and a row of its table."""

from collections.abc import Collection, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict, TypeVar, cast, get_args

import msgspec

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
_Class = TypeVar("_Class")


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


OPTION_TABLE = msgspec.json.decode(
    Path(__file__).with_name("options.json").read_bytes(), type=dict[str, Option]
)
"""Documentation of each option by its name."""
OPTION_TABLE["without"] = replace(
    OPTION_TABLE["without"], choices=(*EXTENSIONS, "joint-noise")
)


def _documented(options: type[_Class]) -> type[_Class]:
    """Return a class whose fields, with their defaults, have their rows of the table."""
    for name, option in OPTION_TABLE.items():
        unset = vars(options)[name]
        setattr(options, name, field(default=unset, metadata=asdict(option)))
    return options


@dataclass(frozen=True, kw_only=True)
@_documented
class SolveOptions:
    """Options of a calibration, which ``options.json`` documents.

    None, or an empty sequence, stands for the default.
    """

    method: Method = "auto"
    distance: float | Sequence[float] | None = None
    free: Sequence[str] = ()
    fix: Sequence[str] = ()
    as_recorded: bool = False
    leave_out: Sequence[str] = ()
    flange_poses: bool = False
    repeatability_mm: float | None = None
    accept_distorted: bool = False
    no_proof: bool = False
    scale: float | None = None
    known: Sequence[str | Path | KnownDistance] = ()
    sockets_at: str | Path | Sequence[str | Path | SocketAt] = ()
    distance_deviation: float | None = None
    without: Sequence[str] = ()
    zeros: bool | None = None
    prior: str | Path | None = None
    remounted: Sequence[str] = ()
    payload: float | str | Sequence[str | float] | None = None
    gravity: Sequence[float] | None = None
    optimizer: Optimizer | None = None
    regularization: float | None = None
    max_iterations: int | None = None

    def validated(self) -> "SolveOptions":
        """Return the options with defaults filled in, and files read; refuse what cannot be."""
        if self.method not in get_args(Method):
            raise UsageError(
                f"method {self.method!r}: choose one of {', '.join(get_args(Method))}"
            )
        filled: dict[str, Any] = {}
        for name, option in OPTION_TABLE.items():
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
        return self.distance_deviation or OPTION_TABLE["distance_deviation"].default

    def as_dict(self) -> dict[str, Any]:
        """Return the options of this method by name, as they stand in ``calibration.json``."""
        return {
            name: _plain(getattr(self, name))
            for name, option in OPTION_TABLE.items()
            if name != "method" and option.method in (None, self.method)
        }


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
