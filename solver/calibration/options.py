"""Options of a calibration; a new one is one more field, and its text in ``options.txt``."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from ..bayes.model.effects import EXTENSIONS
from .option import Method, Option, UsageError, option_texts

if TYPE_CHECKING:
    from ..data import KnownDistance, Load, SocketAt
else:  # the command line reads the types of the fields, and has words for these
    KnownDistance = SocketAt = str

Optimizer = Literal["gauss-newton", "ipopt"]


def _option(unset: Any = None, **about: Any) -> Any:
    """Field of an option, with what :class:`Option` holds beyond its text."""
    return field(default=unset, metadata=about)


@dataclass(frozen=True, kw_only=True)
class SolveOptions:
    """Options of a calibration, explained in ``options.txt``.

    None, or an empty sequence, stands for the default.
    """

    method: Method = "auto"
    distance: float | None = None
    free: Sequence[str] = ()
    fix: Sequence[str] = ()
    split_moved: bool = False
    flange_poses: bool = False
    repeatability_mm: float | None = _option(within=(1e-9, 1e4), unit="millimetres")
    accept_distorted: bool = False
    known: Sequence[str | Path | KnownDistance] = ()
    sockets_at: str | Path | Sequence[str | Path | SocketAt] = ()
    distance_deviation: float | None = _option(default=3e-5, within=(1e-12, 1.0), unit="metres")
    without: Sequence[str] = _option(unset=(), choices=(*EXTENSIONS, "joint-noise"))
    zeros: bool | None = _option(default=False)
    type_prior: Sequence[str | Path] = _option(unset=(), default=("shipped",))
    prior: str | Path | None = None
    remounted: Sequence[str] = _option(unset=(), choices=("tool", "base"))
    payload: float | None = _option(within=(0.0, 1e3), unit="kilograms, zero or more")
    gravity: Sequence[float] | None = _option(
        within=(9.0, 11.0),
        unit="its three components in m/s^2, for an arm that hangs from the ceiling 0 0 9.81",
    )
    optimizer: Optimizer | None = _option(default="gauss-newton")
    regularization: float | None = _option(default=1e-4)
    max_iterations: int | None = _option(default=200, within=(1, 10**9), unit="at least 1")

    def validated(self) -> "SolveOptions":
        """Return the options with defaults filled in, and files read; refuse what cannot be."""
        from ..data import read_known

        if self.method not in get_args(Method):
            raise UsageError(f"method {self.method!r}: choose one of {', '.join(get_args(Method))}")
        filled: dict[str, Any] = {}
        for name, option in option_table().items():
            value, unset = getattr(self, name), getattr(SolveOptions, name)
            mine = option.method in (None, self.method)
            if value is None or (isinstance(value, Sequence) and not value):
                filled[name] = value if option.default is None or not mine else option.default
                continue
            if not mine:
                words = f"--{name.replace('_', '-')} belongs to --method {option.method}"
                raise UsageError(f"{words}; this is --method {self.method}")
            filled[name] = (value,) if unset == () and isinstance(value, str | Path) else value
            option.check(name, filled[name])
        if self.remounted and self.prior is None:
            raise UsageError("--remounted: since which calibration? Name it by --prior")
        options = replace(self, **filled)
        return replace(
            options,
            known=tuple(read_known(options.known)),
            sockets_at=tuple(options.located),
            type_prior=tuple(map(str, options.type_prior)),
            prior=None if options.prior is None else str(options.prior),
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
    texts = option_texts()
    return {
        one.name: Option(**texts["SolveOptions", one.name], **one.metadata)
        for one in fields(SolveOptions)
    }


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
