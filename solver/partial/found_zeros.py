"""Zeros of joints that were found, in words and as files."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ..calibration import Calibration, UsageError
from ..identification.robot import Robot
from ..results import refuse_existing, write_files
from .system import System
from .updated import updated, urdf_with_zeros
from .zero_posterior import SURE
from .zeros import TICK, JointZero

EVEN = 0.5
"""Probability of no change below which some zero may have changed."""


@dataclass(frozen=True)
class Zeros:
    """Changes of joint zeros, estimated with the calibrated chain held."""

    arm: Calibration | Robot
    joints: tuple[JointZero, ...]
    """All of the arm's, in chain order."""
    unchanged: float | None
    """Probability that none changed; None where joints were named."""
    noise: float
    """Of the ball in its sockets, a standard deviation per axis [m]."""
    untold: tuple[str, ...]
    """Joints whose zeros are not identifiable, and samples that would help; or another warning."""
    system: System
    """The fit."""
    new: bool = True
    """False where the calibration was trained on all samples, so that they show no change."""
    other: bool = False
    """True where more than zeros differ from a nominal model."""
    scatter: str = ""
    """A sentence that all joints scatter alike; empty where they do not."""

    @property
    def decided(self) -> bool:
        """True where the samples say which zeros changed, or that none did."""
        likely = self.unchanged is None or self.unchanged >= EVEN
        return self.new and not self.scatter and (likely or bool(self.changed))

    @property
    def changed(self) -> tuple[JointZero, ...]:
        """The joints whose zero changed, of those that are identifiable."""
        return tuple(joint for joint in self.joints if joint.offset)

    def __repr__(self) -> str:
        return "\n".join(self.text) or "Nothing was found."

    @property
    def calibration(self) -> Calibration | None:
        """The calibration with the new zeros; None of an arm that has none."""
        if isinstance(self.arm, Robot):
            return None
        return updated(self.arm, self.system, self.joints)

    def urdf(self) -> bytes:
        """Return the URDF with the new zeros in its origins."""
        if isinstance(self.arm, Robot):
            return urdf_with_zeros(self.arm, [joint.offset for joint in self.joints])
        return updated(self.arm, self.system, self.joints).urdf()

    def save(
        self,
        folder: str | Path,
        *,
        force: bool = False,
        pages: Mapping[str, bytes] | None = None,
    ) -> dict[str, str]:
        """Write ``calibrated.urdf`` and ``calibration.json``; the URDF alone for a nominal robot.

        With them come ``pages``, by name. The other arguments and the result are those of
        :meth:`.Calibration.save`.

        Raises:
            OutputError: The folder is there already, or cannot be written.
            UsageError: The calibration was trained on all samples.
        """
        if not self.new:
            raise UsageError(
                "nothing was found that could be written: no sample is new"
            )
        if self.calibration is not None:
            return self.calibration.save(
                folder, force=force, accept_distorted=True, pages=lambda _: pages or {}
            )
        refuse_existing(Path(folder), force=force)
        contents = {**(pages or {}), "calibrated.urdf": self.urdf()}
        files = write_files(Path(folder), contents)
        return {"urdf": str(files["calibrated.urdf"])}

    @property
    def brief(self) -> tuple[str, ...]:
        """The answer in words, line by line."""
        evidence = () if self.decided else (self._evidence,)
        return self._lines([zero.brief for zero in self.changed], evidence)

    @property
    def text(self) -> tuple[str, ...]:
        """The result in words, line by line, the answer first."""
        return self._lines(list(map(str, self.changed)), (self._evidence,))

    def _lines(self, zeros: Sequence[str], evidence: Sequence[str]) -> tuple[str, ...]:
        """Return the zeros, what the evidence says, what is not identifiable, and remarks."""
        notes = self.system.task.rows.warnings
        if not self.new:
            return (*notes, *self.untold)
        if self.unchanged is None or not any(zero.told for zero in self.joints):
            return (*zeros, *self.untold, *notes)
        if not (
            self.decided or self.unchanged or any(zero.changed for zero in self.joints)
        ):
            off = f"No zeros explain it: {still_off(self.system)}"
            return (off, *self.untold, *notes)
        return (*zeros, *self._none, *evidence, *self.untold, *notes)

    @property
    def _none(self) -> tuple[str, ...]:
        """A sentence where no zero is named; none where one is, and that suffices."""
        unchanged = self.unchanged or 0.0
        if self.scatter:
            return (self.scatter,)
        if not self.decided:
            may = "changed" if unchanged < 1 - SURE else "may have changed"
            advice = "" if self.other else ": record more samples"
            return (f"Some zero {may}, but these samples cannot show which{advice}.",)
        if self.changed:
            return ()
        if self.other:
            return ("No zero is shown to have changed.",)
        return (f"No zero changed ({100 * unchanged:.0f} %).",)

    @property
    def _evidence(self) -> str:
        """The probabilities that zeros changed, in words."""
        probabilities = ", ".join(
            f"{zero.joint} {100 * zero.changed:.0f} %"
            for zero in self.joints
            if zero.told
        )
        return f"Changed, by the evidence: {probabilities}."

    def as_dict(self) -> dict[str, Any]:
        """Return it by name."""
        rows = [
            {
                **asdict(joint),
                "told": joint.told,
                "degrees": joint.degrees,
                "ticks": joint.offset / TICK,
                "homing_offset": {"feetech": -joint.counts, "dynamixel": joint.counts},
            }
            for joint in self.joints
        ]
        return {
            "joints": rows,
            "changed": [joint.joint for joint in self.changed],
            "unchanged": self.unchanged,
            "noise": self.noise,
            "untold": list(self.untold),
        }


def still_off(system: System) -> str:
    """Return that zeros leave the samples far off, and what else may be wrong."""
    usual = system.task.prior.noise.space
    return (
        f"the samples are still {1e3 * system.rms_error:.2f} mm off, and {1e3 * usual:.2f} are "
        "usual: is --distance right, is it another arm's calibration or model, or did more than "
        "zeros change (mukca check --calibration)?"
    )
