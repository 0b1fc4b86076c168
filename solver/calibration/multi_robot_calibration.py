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
from ..bases import TiedRobots, base_to_base
from ..identification.data import IDENTITY, Pose, as_point
from ..identification.robot import Origin, link_poses
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
        self._poses = {document.robots[0]: IDENTITY}
        """Of the bases in the first one's; those that are not known are missing."""
        for name in document.robots[1:]:
            relative = document.between[f"{document.robots[0]}_to_{name}"]
            if relative.xyz and relative.rpy:
                self._poses[name] = Pose.of(Origin(relative.xyz, relative.rpy))
        self._calibrations: dict[str, Calibration] = {}
        for name, calibration in calibrations.items():
            shared = msgspec.structs.replace(document, output_sha256=None)
            file = msgspec.structs.replace(
                calibration.document, arm_name=name, arms=shared
            )
            arm = Calibration(file, calibration.calibrated, calibration.source)
            arm.base_in = partial(self.base_in, name)
            self._calibrations[name] = arm

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
            Placed(name, arm.calibrated, self.pose(name)) for name, arm in self.items()
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
        rows = list[dict[str, Any]]()
        for name, result in robots.items():
            rows += [{**row, "robot": name} for row in result["placements"]]
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


def common_document(
    calibrations: Mapping[str, Calibration], world: TiedRobots
) -> results.ArmsDocument:
    """Return everything that robots have in common."""
    first, *names = calibrations
    relative = {
        f"{first}_to_{n}": base_to_base(world, i) for i, n in enumerate(names, 1)
    }
    standing = [0, *(i for i, pose in enumerate(relative.values(), 1) if pose.xyz)]
    arms: list[results.GivenArm] = []
    for i, (name, calibration) in enumerate(calibrations.items()):
        document = calibration.document
        folders: dict[str, list[str]] = {"train": [], "test": []}
        for row in document.data:
            folders[row.role].append(row.folder)
        arm = results.GivenArm(
            name=name,
            robot=document.robot,
            options=dict(calibration.robot.loaded_with),
            train=tuple(folders["train"]),
            test=tuple(folders["test"]),
            postures=_postures(world, i) if i in standing else [],
        )
        arms.append(arm)
    return results.ArmsDocument(
        robots=tuple(calibrations),
        between=relative,
        frames=world.frames,
        arms=tuple(arms),
        sockets=tuple(_visited_sockets(world, standing)),
    )


def _visited_sockets(
    world: TiedRobots, standing: Sequence[int]
) -> Iterator[results.VisitedSocket]:
    """Yield the sockets of robots whose bases are known, in the first one's base."""
    known = {world.robots[i].name for i in standing}
    for k, (placement, socket) in enumerate(world.places.labels):
        names = tuple(robot.name for robot in world.robots if k in robot.sockets)
        if not known.isdisjoint(names):
            xyz = as_point(world.centres[k])
            name = f"{placement}:{socket}"
            yield results.VisitedSocket(name=name, xyz=xyz, robots=names)


def _postures(world: TiedRobots, robot: int) -> list[list[list[float]]]:
    """Return how a robot stood at each base that it shares; see :attr:`GivenArm.postures`."""
    arm = world.arms[robot]
    visitor = world.robots[robot]
    others = chain(*(other.sockets for other in world.robots if other is not visitor))
    shared = np.flatnonzero(np.isin(visitor.sockets, list(others)))
    rows = np.flatnonzero(np.isin(arm.data.sockets, shared))
    _, first = np.unique(arm.data.recorded_at[rows], return_index=True)
    q = arm.data.q[rows[first]]
    origins = arm.model.ball.origins(arm.values)
    places = link_poses(arm.model.robot.joints, q, origins)[..., 3]
    return world.poses[visitor.frame].apply(places).round(5).tolist()
