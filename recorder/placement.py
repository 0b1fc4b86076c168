"""A placement: the samples taken at one position of the socket base."""

import math
import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from .joint_columns import Match, joint_order, require_samples
from .recording_error import RecordingError
from .sample import Sample, numbers_of, samples_of_arrays
from .words import Names

SOCKETS = 2
"""Number of sockets of a base by default."""
DEFAULT_DISTANCE = 0.05
"""Distance of the paper's printed sockets, where none is given [m]."""


_OWN = re.compile(r"(hole_\d+|samples|points|poses)\.csv")
"""Files that a folder is read from; others are tables of their own."""


def recorded_at(file: Path) -> Path:
    """Return the folder of a recording's file, or the table that it is."""
    return file.parent if _OWN.fullmatch(file.name) else file


@dataclass(frozen=True, repr=False)
class Placement:
    """All samples taken at one position of the socket base.

    Some 30 configurations of the arm with the ball in socket 0, and as many in socket 1.
    """

    name: str
    """The folder's name after its parent's, as in ``panda_3/frontcenter``."""
    samples: tuple[Sample, ...]
    """The samples, without those that the operator took back."""
    joint_names: tuple[str, ...] | None = None
    """Names of the joints, in the order of each sample's positions; None where the file names
    none."""
    distance: float | None = None
    """Distance between the centres of sockets 0 and 1 [m]; None where ``placement.json`` does not
    give it."""
    distance_assumed: bool = False
    """True where nobody is known to have measured that distance."""
    readings: tuple[float, ...] = ()
    """All readings of that distance by somebody [m]."""
    files: tuple[Path, ...] = ()
    """The files that it was read from; empty for a placement that was made in memory."""
    remarks: tuple[str, ...] = ()
    """Remarks on the files for people, one line each."""
    frame: str | None = None
    """The name of the instrument's frame, where one measured; None where the files give none."""
    robot_name: str | None = None
    """Name of the recorded robot, where there are several."""
    poses_of: str | None = None
    """Meaning of orientations: ``flange`` for poses that an instrument measured of what the flange
    carries; ``camera`` or ``commands``; None where the recording does not tell."""
    kept_alarms: tuple[str, ...] = ()
    """Texts of the alarms while it was recorded, which the operator kept."""
    place: str = ""
    """Name of the base's position: two robots that visited one base recorded the same place. The
    folder's own name, if ``placement.json`` gives none."""
    labels: tuple[str, ...] = ()
    """Texts beside the numbers of the first file, line by line. Where they are called like joints,
    the table has a line for each joint, and is refused."""
    told: bool = False
    """True where a user named the columns of the joints one by one."""
    suggestion: Callable[[int], str] | None = None
    """Says how to name the columns of a foreign table, by the number of joints; else None."""
    beside: tuple[str, ...] = ()
    """Names of columns that count or date the rows, unless a joint is called so."""
    payload: float | None = None
    """Mass at the ball beyond the model's [kg]; None where ``placement.json`` does not give it."""

    def __post_init__(self) -> None:
        if not self.place:
            object.__setattr__(self, "place", self.name.split("/")[-1])
        if not all(sample.place for sample in self.samples):
            last = Counter[int]()
            counted: list[Sample] = []
            for sample in self.samples:
                last[sample.socket] += 1
                place = sample.place or last[sample.socket]
                counted.append(replace(sample, place=place))
            object.__setattr__(self, "samples", tuple(counted))

    @classmethod
    def of_arrays(
        cls,
        name: str,
        positions: ArrayLike,
        sockets: ArrayLike,
        joint_names: Names | None = None,
        *,
        efforts: ArrayLike | None = None,
        temperatures: ArrayLike | None = None,
        distance: float | None = None,
    ) -> "Placement":
        """Return a placement of one's own arrays.

        Args:
            name: Of the placement.
            positions: Joint positions, shape (samples, joints) [rad], [m] for a prismatic joint.
            sockets: Number of each sample's socket, from 0, shape (samples,).
            joint_names: Names of the joints, in the order of the columns; None for the robot's
                order.
            efforts: What the joints exert, shape (samples, joints) [N m]; None where not measured.
            temperatures: Of the arm at each sample, shape (samples,) [K]; None where not measured.
            distance: Between the centres of sockets 0 and 1 [m]; None where it is not known.

        Raises:
            RecordingError: No samples, shapes that do not fit each other, a number that is none, or
                a socket that is no number from 0 to 999.
        """
        where = f"placement {name!r}"
        names = None if joint_names is None else tuple(joint_names)
        samples = samples_of_arrays(
            where, positions, sockets, names, efforts, temperatures
        )
        metres = None
        if distance is not None:
            metres = float(numbers_of(distance, f"{where}: distance"))
        return cls(str(name), samples, names, metres)

    def __repr__(self) -> str:
        counts = np.bincount(self.sockets)
        joints = len(self.samples[0].position) if self.samples else 0
        samples = " + ".join(map(str, counts)) or "0"
        return f"Placement({self.name!r}: {samples} samples, {joints} joints)"

    @cached_property
    def positions(self) -> np.ndarray:
        """Joint positions, shape (samples, joints) [rad], [m] for a prismatic joint."""
        return np.array([sample.position for sample in self.samples], dtype=float)

    @cached_property
    def sockets(self) -> np.ndarray:
        """The number of each sample's socket, from 0, shape (samples,)."""
        return np.array([sample.socket for sample in self.samples], dtype=np.int64)

    @cached_property
    def efforts(self) -> np.ndarray | None:
        """Joint efforts, shape (samples, joints) [N m]; None where a sample lacks them."""
        if any(sample.effort is None for sample in self.samples):
            return None
        return np.array([sample.effort for sample in self.samples], dtype=float)

    @property
    def kind(self) -> Literal["sockets", "points"]:
        """``points`` where an instrument measured each sample's ball, in no socket."""
        return "points" if any(sample.point for sample in self.samples) else "sockets"

    @property
    def path(self) -> Path | None:
        """The folder that it was read from, or the table."""
        file = self.files[0] if self.files else None
        return file if file is None or self.suggestion else file.parent

    @property
    def where(self) -> Path | str:
        """The folder that it was read from, for messages; its name where it was made in memory."""
        return self.path or self.name

    def with_positions(self, positions: np.ndarray) -> "Placement":
        """Return the placement with other joint positions, shape (samples, joints) [rad]."""
        rows: list[list[float]] = positions.tolist()
        pairs = zip(self.samples, rows, strict=True)
        samples = tuple(replace(sample, position=tuple(row)) for sample, row in pairs)
        return replace(self, samples=samples)

    def for_joints(self, joint_names: Names) -> "Placement":
        """Return the placement with its joints in the order in which a robot model has them.

        Joints are matched by name, see :mod:`.columns`. Where the file names none of them, they are
        taken to be in the model's order already, and a remark says so.

        Raises:
            RecordingError: Another number of joints, or a header that names only some of them.
        """
        match = self._order(joint_names)
        if not match:
            return self
        samples = [reordered_sample(sample, match.order) for sample in self.samples]
        filled = [s for s in samples if not all(map(math.isnan, s.position))] or samples
        for sample in filled:
            for name, value in zip(joint_names, sample.position, strict=True):
                if math.isnan(value):
                    raise RecordingError(
                        f"{sample.where}: joint {name!r} is no finite number; delete the line if "
                        "the capture failed"
                    )
        remarks = list(self.remarks)
        if blank := len(samples) - len(filled):
            remarks.append(
                f"{self.first_file}: {blank} lines without joint positions are left out"
            )
        if match.note:
            remarks.append(f"{self.first_file}: {match.note}")
        return replace(
            self,
            samples=tuple(filled),
            joint_names=tuple(joint_names),
            remarks=tuple(remarks),
        )

    def advice(self, otherwise: str) -> str:
        """Return what a user may say of the columns of a table; of others what is passed."""
        m = len(self.samples[0].position)
        return self.suggestion(m) if self.suggestion else otherwise

    def order_note(self, joint_names: Names) -> str:
        """Return the remark that columns are taken in order; empty where they go by name."""
        match = self._order(joint_names)
        return match.note if match else ""

    @property
    def first_file(self) -> Path | str:
        """The first of its files, for messages; its name where it was made in memory."""
        return self.files[0] if self.files else self.name

    def _order(self, joint_names: Names) -> Match | None:
        """Return where a model's joints stand; None where the files name none."""
        require_samples(self.labels, joint_names, self.first_file)
        try:
            return joint_order(
                self.joint_names,
                joint_names,
                self.samples,
                self.first_file,
                self.beside,
                self.told,
            )
        except RecordingError as error:
            if not self.suggestion:
                raise
            words = f"or say which they are, as in {self.suggestion(len(joint_names))}"
            raise RecordingError(f"{error}; {words}") from None


def reordered_sample(sample: Sample, order: Sequence[int]) -> Sample:
    """Return a sample with its joints in another order."""

    def reordered(values: Sequence[float]) -> tuple[float, ...]:
        return tuple(values[i] for i in order)

    return replace(
        sample,
        position=reordered((*sample.position, *sample.beside)),
        spread=sample.spread and reordered(sample.spread),
        effort=sample.effort and reordered(sample.effort),
    )
