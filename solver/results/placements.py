"""Recordings in ``calibration.json``: diagnostics, every sample, and the errors by each model."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from operator import add
from pathlib import Path
from typing import Any, Literal

from msgspec.structs import replace

from ...recorder import Placement, Sample, recorded_at
from ..identification.data import removed_share
from .by_model import MetricsByModel
from .files import Document

Role = Literal["train", "test", "left_out"]
"""Role of a placement: fitted, held out to test the fit, or left out of a fit to all others."""
ROLES: dict[Role, str] = {
    "train": "trained on",
    "test": "held out",
    "left_out": "left out",
}
"""Every role, in words."""


class PlacementErrors(MetricsByModel):
    """Errors of a placement, by each model."""

    name: str
    role: Role
    samples: tuple[int, ...]
    """Number of samples in each socket."""
    kind: Literal["sockets", "points"] = "sockets"
    """``points`` where an instrument measured each ball: the errors are true ones, in space."""
    distance: float | None
    """Between the first two sockets, as measured [m]; None for points."""
    distance_source: str | None = None
    """Source of the distance: ``given``, the ``recording``, or the ``default``."""
    distance_readings: int | None = None
    """Number of readings that agree on it; None in older files."""
    predicted_deviation: float | None = None
    """Root mean square distance of samples from their socket's mean, as predicted [m]."""
    found_deviation: float | None = None
    """The same, as computed from the samples [m]."""
    distance_deviation: float | None = None
    """Standard deviation of the full model's distance error, where it was held out [m]."""

    @property
    def has_distance(self) -> bool:
        """True where the distance is between two sockets that have samples."""
        return self.distance is not None and len(self.samples) > 1


class Summary(MetricsByModel):
    """The means over the placements of one role."""

    removed_error: float
    """1 - calibrated / nominal, of the mean absolute error."""

    @property
    def removed_when_loaded(self) -> float:
        """1 - loaded / before, of the mean absolute error."""
        return removed_share(self.before, self.loaded)

    @property
    def removed_by_full(self) -> float:
        """The same with joint positions corrected first."""
        return removed_share(self.before, self.calibrated)


class Summaries(Document):
    """A summary for each role; None where no placement has it."""

    train: Summary | None
    test: Summary | None
    left_out: Summary | None = None

    @property
    def proof(self) -> Summary | None:
        """Of what a fit did not see: held out, or where nothing is, left out; None without any."""
        return self.test or self.left_out


class CostTerms(Document):
    """The first two terms of Eq. (5), mean over the placements of a role [m^2]."""

    inconsistency: float
    distortion: float


class Iteration(Document):
    """Cost after one step of the fit."""

    iteration: int
    train: CostTerms | None
    test: CostTerms | None


_KEPT = (
    "socket",
    "position",
    "effort",
    "point",
    "orientation",
    "where",
    "number",
    "place",
    "time",
    "temperature",
)
"""All that a document keeps of a :class:`.Sample`."""


class RecordedSample(Document):
    """One sample; its joint positions in the chain's order [rad, m for prismatic joints]."""

    socket: int
    position: tuple[float, ...]
    effort: tuple[float, ...] | None
    """Joint efforts [N m]; None where they were not measured."""
    point: tuple[float, float, float] | None = None
    """Position of the ball in the frame of an instrument [m]; None for a ball in a socket."""
    orientation: tuple[float, float, float, float] | None = None
    """Measured orientation of its link in that frame, as a unit quaternion x, y, z, w."""
    where: str = ""
    """File and line."""
    number: int = 0
    """As the recording numbers it, from 1; 0 where it does not."""
    place: int = 0
    """Counts the samples of its socket as recorded, from 1; 0 in older files."""
    weight: float | None = None
    """Robust weight in the fit: 1 and less; None where there was none."""
    orientation_weight: float | None = None
    """The same of the measured orientation."""
    time: float | None = None
    """When it was captured [s since 1970, UTC]."""
    temperature: float | None = None
    """Of the arm at its capture [K]; None where it was not measured."""
    fold: int | None = None
    """Number of the fold that leaves it out, from 0; None where none does."""
    moved: tuple[float, float, float] | None = None
    """Movement of its place until then, as the fit found it [m]; None where it stood still."""


class PlacementSamples(Document):
    """The samples of one placement."""

    name: str
    role: Role
    distance: float
    files: tuple[str, ...]
    frame: str | None = None
    """The instrument's frame, where its recording names it."""
    payload: float | None = None
    """Mass at the ball beyond the model's [kg]; None for that of the calibration's load."""
    samples: tuple[RecordedSample, ...]

    @property
    def folder(self) -> str:
        """Folder or table of its recording; a question mark for samples that came from no file."""
        return str(recorded_at(Path(self.files[0]))) if self.files else "?"

    @property
    def by_socket(self) -> tuple[RecordedSample, ...]:
        """The samples socket after socket, as fits have them."""
        return tuple(sorted(self.samples, key=lambda sample: sample.socket))

    def shifted(self, offsets: Sequence[float]) -> "PlacementSamples":
        """Return the samples as joints read them that read more by some offsets [rad], [m]."""
        samples = (
            replace(s, position=tuple(map(add, s.position, offsets)))
            for s in self.samples
        )
        return replace(self, samples=tuple(samples))

    def placement(self, joint_names: tuple[str, ...]) -> Placement:
        """Return the placement as it was recorded, columns in the chain's order."""
        samples = (
            Sample(**{key: getattr(s, key) for key in _KEPT}) for s in self.samples
        )
        return Placement(
            name=self.name,
            samples=tuple(samples),
            joint_names=joint_names,
            distance=self.distance,
            files=tuple(map(Path, self.files)),
            frame=self.frame,
            poses_of="flange",
            payload=self.payload,
        )


@dataclass(frozen=True)
class Consequence:
    """Change of the distances that a model predicts if an explanation is heeded [m]."""

    near: float
    """Near the recorded places, at the worst of them; like all of these the median."""
    workspace: float
    near_before: float
    """Errors of the nominal model, its ball refitted, at the same places."""
    workspace_before: float

    def __str__(self) -> str:
        at_places = f"{1e3 * self.near:.2g}"
        everywhere = f"{1e3 * self.workspace:.2g}"
        return (
            f"effect on distances: {at_places} mm near the recorded places, "
            f"{everywhere} mm elsewhere"
        )


@dataclass(frozen=True)
class Diagnostic:
    """One thing that was seen."""

    level: str
    """``error``: do not train on it as it is; ``warning``: look at it; ``note``: it matters
    little."""
    code: str
    where: str
    text: str
    advice: str
    consequence: Consequence | None = None
    """Its effect on the model; None where no fit with it and without it tells."""

    def as_dict(self) -> dict[str, Any]:
        """Return it by name."""
        return asdict(self)

    @property
    def words(self) -> str:
        """The finding, its effect and the advice, without its place."""
        weight = "" if self.consequence is None else f" ({self.consequence})"
        return f"{self.text}{weight}; {self.advice or 'look at it'}"

    def __str__(self) -> str:
        return f"{self.where}: {self.words}"


@dataclass(frozen=True)
class Hypothesis:
    """An explanation of the recordings, with its probability."""

    name: str
    """As in the documentation's list of causes; ``sound`` where nothing is wrong."""
    probability: float
    parameters: dict[str, float | str | list[float]]
    """Numbers and names by which it is told: lengths in m, angles in rad, samples from 0."""
    text: str
    advice: str
    tell: str
    """Step that tells it from others."""
    fits_as_well: bool = False
    """True where it explains the samples as well as the first, by more unknowns or fewer."""


class NextPlacement(Document):
    """Place to record next, in words."""

    text: str
