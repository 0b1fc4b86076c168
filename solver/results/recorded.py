"""What was recorded, in ``calibration.json``: every sample, and what pulled at the joints."""

from pathlib import Path

from ...recorder.dataset import Placement, Sample
from .errors import Role
from .files import Document


class RecordedSample(Document, kw_only=True, frozen=True):
    """One sample; its joint positions in the chain's order [rad, m for prismatic joints]."""

    socket: int
    position: tuple[float, ...]
    effort: tuple[float, ...] | None
    """What the joints exerted [N m]; None where it was not measured."""
    point: tuple[float, float, float] | None = None
    """Where an instrument measured the ball, in its frame [m]; None for a ball in a socket."""
    where: str = ""
    """File and line."""
    weight: float | None = None
    """Robust weight in the fit: 1 and less; None where there was none."""


class PlacementSamples(Document, kw_only=True, frozen=True):
    """The samples of one placement."""

    name: str
    role: Role
    distance: float
    files: tuple[str, ...]
    frame: str | None = None
    """The instrument's frame, where its recording names it."""
    samples: tuple[RecordedSample, ...]

    @property
    def folder(self) -> str:
        """Where it was recorded; a question mark for samples that came from no file."""
        return str(Path(self.files[0]).parent) if self.files else "?"

    def placement(self, joint_names: tuple[str, ...]) -> Placement:
        """Return the placement as it was recorded, columns in the chain's order."""
        return Placement(
            name=self.name,
            samples=tuple(
                Sample(s.position, s.socket, s.effort, s.where, point=s.point) for s in self.samples
            ),
            joint_names=joint_names,
            distance=self.distance,
            files=tuple(map(Path, self.files)),
            frame=self.frame,
        )


class CarriedLoad(Document, kw_only=True, frozen=True):
    """What pulled at the joints while recording."""

    gravity: tuple[float, float, float]
    """In the base frame [m/s^2]."""
    payload: float
    """Mass at the ball beyond that of the model [kg]."""
