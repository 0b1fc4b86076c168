"""Several robots that were calibrated together, and calibrations read from files."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from .. import results
from ..bases import TiedRobots
from ..identification.data import Measurement, Pose
from ..identification.robot import Origin
from .arms_document import common_document, known_poses, with_urdf_poses
from .calibration import Calibration, DistortedError
from .errors import Errors
from .multi_robot_urdf import Placed, joined_urdf
from .option import UsageError


class MultiRobotCalibration(Mapping[str, Calibration]):
    """Calibrations of several robots by name, and the relative poses of their bases.

    Args:
        calibrations: Of each robot.
        document: Everything that they have in common, as ``arms.json`` holds it.
    """

    def __init__(
        self,
        calibrations: Mapping[str, Calibration],
        document: results.ArmsDocument,
    ) -> None:
        self.document = document
        self._poses = known_poses(document)
        self._calibrations: dict[str, Calibration] = {}
        for name, calibration in calibrations.items():
            shared = msgspec.structs.replace(document, output_sha256=None)
            file = msgspec.structs.replace(
                calibration.document, arm_name=name, arms=shared
            )
            arm = Calibration(file, calibration.calibrated, calibration.source)
            arm.base_in = partial(self.base_in, name)
            self._calibrations[name] = arm

    @staticmethod
    def of(
        calibrations: Mapping[str, Calibration],
        world: TiedRobots,
        data: Mapping[str, Sequence[Measurement]],
    ) -> "MultiRobotCalibration":
        """Return robots that were tied in one world, by the placements trained on."""
        document = common_document(calibrations, world)
        arms = {name: arm.calibrated for name, arm in calibrations.items()}
        return MultiRobotCalibration(
            calibrations, with_urdf_poses(document, arms, data)
        )

    def __getitem__(self, name: str) -> Calibration:
        return self._calibrations[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._calibrations)

    def __len__(self) -> int:
        return len(self._calibrations)

    def pose(self, name: str) -> Pose:
        """Return where a robot's base stands in the first one's.

        With the calibrated robots it says where one tool stands seen from the other::

            arms.pose("right").apply(arms["right"].ball(q_right)) - arms["left"].ball(q_left)

        Raises:
            UsageError: No such robot, or the recordings do not tell where it stands.
        """
        if name not in self._poses:
            relative = self.document.between.get(f"{self.document.robots[0]}_to_{name}")
            raise UsageError(
                relative.text if relative else f"no robot is called {name!r}"
            )
        return self._poses[name]

    def urdf_pose(self, name: str) -> Pose:
        """Return where ``arms.urdf`` has a robot's base in the first one's; see :meth:`pose`.

        It is fitted for both ``calibrated.urdf``: the full models' pose has another error there.
        """
        pose = self.pose(name)
        if name == self.document.robots[0]:
            return pose
        urdf = self.document.between[f"{self.document.robots[0]}_to_{name}"].urdf
        return Pose.of(Origin(urdf.xyz, urdf.rpy)) if urdf else pose

    def base_in(self, name: str, frame: str, at: ArrayLike | None = None) -> np.ndarray:
        """Return the pose of a robot's base in a frame, shape (4, 4) [m].

        Args:
            name: The robot.
            frame: Another robot, for its base; ``right/flange``, or another link that stands still
                on it, for what it carries; or a frame in which positions were measured.
            at: Joint positions of that other robot where the frame moves with it, shape (m,).

        Raises:
            UsageError: No such frame, or the recordings do not tell where it is.
        """
        robot, _, link = frame.partition("/")
        measured = {f.name: Pose.of(Origin(f.xyz, f.rpy)) for f in self.document.frames}
        if robot not in self and (link or robot not in measured):
            of_robots = [f"{robot_name}, {robot_name}/flange" for robot_name in self]
            names = ", ".join([*of_robots, *measured])
            raise UsageError(f"frame {frame!r}: there is none; there are: {names}")
        place = (self.pose(robot) if robot in self else measured[robot]).matrix
        if link:
            if at is None:
                raise UsageError(
                    f"frame {frame!r}: say by `at` which joint positions {robot} has"
                )
            place = place @ self[robot].flange(
                at, tool=None if link == "flange" else link
            )
        return np.linalg.inv(place) @ self.pose(name).matrix

    def urdf(self, folder: Path | None = None) -> bytes:
        """Return one URDF with all robots, each in its place; see :meth:`.CalibratedRobot.urdf`."""
        placed = [
            Placed(name, arm.calibrated, self.urdf_pose(name))
            for name, arm in self.items()
        ]
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

        Without ``arms.urdf`` where the recordings do not tell where a robot stands. Args and errors
        are those of :meth:`Calibration.save`.
        """
        folder = Path(folder)
        results.refuse_existing(folder, force=force)
        for calibration in self.values():
            if refusal := calibration.refusal(accept_distorted):
                raise DistortedError(refusal)
        outputs: dict[str, str] = {}
        contents: dict[str, bytes] = {}
        for name, calibration in self.items():
            paths, files = calibration.files_in(folder / name, accept_distorted, pages)
            outputs |= {f"{name}_{kind}": path for kind, path in paths.items()}
            contents |= {f"{name}/{file}": content for file, content in files.items()}
        named = [f"{name}/calibration.json" for name in self]
        if len(self._poses) == len(self):
            contents["arms.urdf"] = self.urdf(folder)
            outputs["urdf"] = str(folder / "arms.urdf")
            named.append("arms.urdf")
        document = msgspec.structs.replace(
            self.document,
            format=results.ARMS_FORMAT,
            output_sha256={file: results.sha256(contents[file]) for file in named},
        )
        arms = {"arms.json": results.encode(document, indent=1)}
        results.write_files(folder, arms | contents)
        return outputs | {"arms": str(folder / "arms.json")}

    def as_dict(self) -> dict[str, Any]:
        """Return everything by name, as the command line's JSON has it."""
        robots = {name: arm.result.as_dict() for name, arm in self.items()}
        rows = [
            {**row, "robot": name}
            for name, result in robots.items()
            for row in result["placements"]
        ]
        errors = Errors(chain(*(arm.document.placements for arm in self.values())))
        first = next(iter(robots.values()))
        same = ("method", "optimizer", "iterations", "converged", "solve_seconds")
        shared = self.document.as_dict()
        return {
            "robot": ", ".join(
                f"{name}={result['robot']}" for name, result in robots.items()
            ),
            **{key: first[key] for key in same},
            "placements": rows,
            "summary": errors.summary.as_dict(),
            "robots": robots,
            **shared["between"],
            "frames": shared["frames"],
        }

    def __repr__(self) -> str:
        parts = [f"{name}: {calibration!r}" for name, calibration in self.items()]
        parts += [relative.text for relative in self.document.between.values()]
        return "\n\n".join(parts)
