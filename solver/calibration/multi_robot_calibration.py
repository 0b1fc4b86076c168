"""Several robots that were calibrated together, and the relative poses of their bases."""

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ..bayes.inference import JointPosterior
from ..bayes.results import RelativeBasePose, between
from ..data import IDENTITY, Pose, as_point
from ..results import ArmsDocument, BaseToBase, GivenArm, encode, refuse_existing, write_files
from .calibration import Calibration, DistortedError
from .error_table import Errors
from .frames import frame_poses, postures, visited_sockets
from .multi_robot_urdf import Placed, joined_urdf


class MultiRobotCalibration(Mapping[str, Calibration]):
    """Calibrations of several robots by name, and the relative poses of their bases.

    Args:
        calibrations: Of each robot.
        posterior: Joint posterior of all robots and frames.
    """

    def __init__(self, calibrations: Mapping[str, Calibration], posterior: JointPosterior) -> None:
        self._calibrations = dict(calibrations)
        self._posterior = posterior
        for name, one in calibrations.items():
            document = msgspec.structs.replace(one.document, arm_name=name, arms=self.document)
            self._calibrations[name] = Calibration(document, one.calibrated)

    def __getitem__(self, name: str) -> Calibration:
        return self._calibrations[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._calibrations)

    def __len__(self) -> int:
        return len(self._calibrations)

    @cached_property
    def document(self) -> ArmsDocument:
        """Document of everything that the robots have in common, as ``arms.json`` holds it."""
        names = tuple(self)
        pairs = [between(self._posterior, i) for i in range(1, len(names))]
        return ArmsDocument(
            robots=names,
            between={f"{one.names[0]}_to_{one.names[1]}": _base_to_base(one) for one in pairs},
            frames=frame_poses(self._posterior),
            arms=tuple(self._given(name) for name in names),
            sockets=visited_sockets(self._posterior),
        )

    def _given(self, name: str) -> GivenArm:
        document = self[name].document
        return GivenArm(
            name=name,
            robot=document.robot,
            options=dict(self[name].robot.loaded_with),
            train=tuple(row.folder for row in document.data if row.role == "train"),
            test=tuple(row.folder for row in document.data if row.role == "test"),
            postures=postures(self._posterior, list(self).index(name)),
        )

    def pose(self, name: str) -> Pose:
        """Return where a robot's base stands in the first one's.

        With the calibrated robots it says where one tool stands seen from the other::

            arms.pose("right").apply(arms["right"].ball(q_right)) - arms["left"].ball(q_left)
        """
        robot = list(self).index(name)
        frames = list(self._posterior.frames.values())
        return IDENTITY if robot == 0 else frames[self._posterior.scene.bases[robot]]

    def urdf(self, folder: Path | None = None) -> bytes:
        """Return one URDF with all robots, each where the calibration has it.

        Args:
            folder: Where it will stand; relative mesh paths are rewritten. None leaves them.
        """
        placed = [Placed(name, one.calibrated, self.pose(name)) for name, one in self.items()]
        return joined_urdf(placed, folder)

    def save(
        self,
        folder: str | Path,
        *,
        force: bool = False,
        accept_distorted: bool | None = None,
        pages: Callable[[Calibration], Mapping[str, bytes]] | None = None,
    ) -> dict[str, str]:
        """Write each robot's files into a folder of its own, ``arms.urdf`` and ``arms.json``.

        Args and errors are those of :meth:`Calibration.save`.
        """
        folder = Path(folder)
        refuse_existing(folder, force=force)
        for calibration in self.values():
            if refusal := calibration.refusal(accept_distorted):
                raise DistortedError(refusal)
        contents = {"arms.urdf": self.urdf(folder), "arms.json": encode(self.document, indent=1)}
        outputs: dict[str, str] = {}
        for name, calibration in self.items():
            written = calibration.save(
                folder / name, force=force, accept_distorted=accept_distorted, pages=pages
            )
            outputs |= {f"{name}_{kind}": path for kind, path in written.items()}
        write_files(folder, contents)
        return outputs | {"urdf": str(folder / "arms.urdf"), "arms": str(folder / "arms.json")}

    def as_dict(self) -> dict[str, Any]:
        """Return everything by name, as the command line's JSON has it."""
        robots = {name: one.result.as_dict() for name, one in self.items()}
        rows = [{**row, "robot": name} for name, one in robots.items() for row in one["placements"]]
        errors = Errors(row for one in self.values() for row in one.document.placements)
        first = next(iter(robots.values()))
        same = ("method", "optimizer", "iterations", "converged", "solve_seconds")
        common = self.document.as_dict()
        return {
            "robot": ", ".join(f"{name}={one['robot']}" for name, one in robots.items()),
            **{key: first[key] for key in same},
            "placements": rows,
            "summary": errors.summary.as_dict(),
            "robots": robots,
            **common["between"],
            "frames": common["frames"],
        }

    def __repr__(self) -> str:
        parts = [f"{name}: {one!r}" for name, one in self.items()]
        return "\n\n".join([*parts, *(one.text for one in self.document.between.values())])


def _base_to_base(one: RelativeBasePose) -> BaseToBase:
    """Return numbers and words; the numbers only where they mean something."""
    known, origin = one.unseen is None, one.pose.origin
    deviation = np.sqrt(np.diag(one.covariance).clip(min=0))
    return BaseToBase(
        xyz=origin.xyz if known else None,
        rpy=origin.rpy if known else None,
        xyz_deviation=as_point(deviation[3:]) if known else None,
        turn_deviation=as_point(deviation[:3]) if known else None,
        tool_deviation=one.tools if known else None,
        shared_sockets=one.shared,
        text=_words(one, deviation) if one.unseen is None else _turned(one, one.unseen),
    )


def _words(one: RelativeBasePose, deviation: np.ndarray) -> str:
    first, second = one.names
    place = " ".join(f"{1e3 * value:+.2f}" for value in one.pose.origin.xyz)
    turned = " ".join(f"{np.degrees(value):+.3f}" for value in one.pose.origin.rpy)
    frames = (
        f"{second}'s base stands at {place} mm (+- {1e3 * deviation[3:].max():.2f}), turned "
        f"{turned} deg (+- {np.degrees(deviation[:3].max()):.2f}) in {first}'s: no better, since "
        "each base frame hangs on its own joint 1 zero, which no ball shows"
    )
    if one.tools is None:
        return f"{frames}. No place was found that both tools reach."
    return (
        f"Tool to tool, where {second}'s tool stands seen from {first}'s in the shared region, is "
        f"known to {1e3 * one.tools:.2f} mm (1 sigma), by both calibrated models together. "
        f"{frames[0].upper()}{frames[1:]}."
    )


def _turned(one: RelativeBasePose, axis: np.ndarray) -> str:
    """Return what is missing where a turn of one robot against the other is left."""
    first, second = one.names
    along = " ".join(f"{value:+.2f}" for value in axis)
    count = {0: "no socket", 1: "one socket", 2: "two sockets"}.get(
        one.shared, f"{one.shared} sockets on one line"
    )
    left = "about their line" if one.shared > 1 else "about it"
    return (
        f"{second} stands nowhere yet seen from {first}: {count} shared leave it free to turn "
        f"{left} (along {along} in {first}'s base). Let both record one more placement, off that "
        "line: two placements cure it, three are better."
    )
