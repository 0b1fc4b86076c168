"""What a calibration can be told, and what goes with which method."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from ..data import CALIPER_DEVIATION, KnownDistance, Load, parse_known
from ..paper import MAX_ITERATIONS, OPTIMIZERS, REGULARIZATION
from ..robot import STANDARD_GRAVITY
from .usage import UsageError

METHODS = ("auto", "paper")
SHIPPED = "shipped"
ONLY_AUTO: dict[str, Any] = {
    "known": (),
    "sockets_at": (),
    "distance_deviation": CALIPER_DEVIATION,
    "without": (),
    "zeros": False,
    "type_prior": (SHIPPED,),
    "payload": None,
    "gravity": None,
}
"""Settings of the default method, and their defaults."""
ONLY_PAPER: dict[str, Any] = {
    "optimizer": OPTIMIZERS[0],
    "regularization": REGULARIZATION,
    "max_iterations": MAX_ITERATIONS,
}
"""Settings of the paper's method, and their defaults."""


@dataclass(frozen=True)
class Settings:
    """How to calibrate. None, or nothing in a sequence, stands for the default."""

    method: str = "auto"
    """``auto``: geometry, elasticity and transmission error, as far as the data support
    them; ``paper``: Eq. (5), geometry alone."""
    distance: float | None = None
    """Between the sockets' centres [m]; None for the recording's, or 0.05."""
    free: Sequence[str] = ()
    """What of the geometry is free: joint names, ``JOINT.x`` .. ``JOINT.yaw``, ``JOINT.xyz`` or
    ``JOINT.rpy``; ``*`` stands for any text."""
    fix: Sequence[str] = ()
    """What is not, by the same words."""
    split_moved: bool = False
    """Where a base moved, give the part after it a socket of its own."""
    repeatability_mm: float | None = None
    """Of the arm [mm], which the verdict's limits rest on; None for what is known of it."""
    accept_distorted: bool = False
    """Save even a model that does not reproduce the distance of the sockets."""
    known: Sequence[str] = ()
    """auto: further measured distances, ``left:0-right:0=0.175+-0.0001`` in metres."""
    sockets_at: Sequence[str] = ()
    """auto: measured coordinates of sockets, ``table/front:0=0.1,0.2,0.03+-0.00005`` in metres."""
    distance_deviation: float | None = None
    """auto: standard deviation of the distance [m]; None for a caliper's, 3e-5."""
    without: Sequence[str] = ()
    """auto: what is not tried, among ``compliance``, ``tilt``, ``play``, ``transmission`` and
    ``joint-noise``."""
    zeros: bool | None = None
    """auto: the joints' zeros may be off by degrees, as on arms made of servos."""
    type_prior: Sequence[str] = ()
    """auto: ``calibration.json`` files of other arms of the type, whose elasticity is alike;
    ``shipped``, the default, for what was measured of shipped robots' types; ``none``."""
    payload: float | None = None
    """auto: mass at the ball beyond the model's [kg]."""
    gravity: Sequence[float] | None = None
    """auto: acceleration in the base frame [m/s^2], for an arm on a wall or ceiling."""
    optimizer: str | None = None
    """paper: ``gauss-newton`` or ``ipopt``."""
    regularization: float | None = None
    """paper: lambda of Eq. (5); None for 1e-4."""
    max_iterations: int | None = None
    """paper: steps allowed; None for 200."""

    def settled(self) -> "Settings":
        """Return the settings with defaults filled in.

        Raises:
            UsageError: A setting of the other method, which would do nothing, or a value that
                cannot be. The words are those of the command line.
        """
        if self.method not in METHODS:
            raise UsageError(f"method {self.method!r}: choose one of {', '.join(METHODS)}")
        filled: dict[str, Any] = {}
        for method, only in (("paper", ONLY_PAPER), ("auto", ONLY_AUTO)):
            for name, default in only.items():
                given = getattr(self, name)
                if given is None or (isinstance(given, Sequence) and not given):
                    filled[name] = default
                elif self.method != method:
                    raise UsageError(
                        f"--{name.replace('_', '-')} belongs to --method {method}; this is "
                        f"--method {self.method}"
                    )
        settled = replace(self, **filled)
        settled._check()
        return settled

    def _check(self) -> None:
        assert self.max_iterations is not None and self.distance_deviation is not None
        if self.max_iterations < 1:
            raise UsageError(f"--max-iterations {self.max_iterations}: at least 1 is needed")
        if not 0 < self.distance_deviation < 1:
            raise UsageError(f"--distance-deviation {self.distance_deviation}: give metres")
        if self.repeatability_mm is not None and not 0 < self.repeatability_mm < 1e4:
            raise UsageError(f"--repeatability-mm {self.repeatability_mm}: give millimetres")
        unknown = [w for w in self.without if w not in _WITHOUT]
        if unknown:
            raise UsageError(f"--without {unknown[0]}: choose among {', '.join(_WITHOUT)}")
        if self.payload is not None and not 0 <= self.payload < 1000:
            raise UsageError(f"--payload {self.payload}: give kilograms, zero or more")
        if self.gravity is not None:
            strength = math.hypot(*self.gravity)
            if len(self.gravity) != 3 or not 9 < strength < 11:
                raise UsageError(
                    f"--gravity: {strength:.3g} m/s^2; give its three components, for an arm that "
                    "hangs from the ceiling 0 0 9.81"
                )

    @property
    def load(self) -> Load:
        """What pulls at the joints."""
        gravity = STANDARD_GRAVITY
        if self.gravity is not None:
            x, y, z = self.gravity
            gravity = (x, y, z)
        return Load(gravity, self.payload or 0.0)

    @property
    def distances(self) -> list[KnownDistance]:
        """The known distances."""
        return [parse_known(words) for words in self.known]

    @property
    def deviation(self) -> float:
        """Standard deviation of the distance between a base's sockets [m]."""
        return self.distance_deviation or CALIPER_DEVIATION

    def of_paper(self) -> dict[str, Any]:
        """Return the arguments of :func:`mukca.solver.calibration.fit.fit_by_paper`."""
        return {name: getattr(self, name) for name in ONLY_PAPER}

    def of_auto(self) -> dict[str, Any]:
        """Return the arguments of :func:`mukca.solver.calibration.fit.fit_by_auto`."""
        return {
            "known": self.distances,
            "distance_deviation": self.deviation,
            "load": self.load,
            "without": self.without,
            "zeros": bool(self.zeros),
        }

    def as_dict(self) -> dict[str, Any]:
        """Return what matters for this method, by name, as it stands in ``calibration.json``."""
        other = ONLY_PAPER if self.method == "auto" else ONLY_AUTO
        rows = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in other}
        del rows["method"]
        return {
            name: list(value) if isinstance(value, tuple | list) else value  # pyright: ignore
            for name, value in rows.items()
        }


_WITHOUT = ("compliance", "tilt", "play", "transmission", "joint-noise")
