"""A zoo of awkward recordings: of real and simulated arms, spoilt by name, or at random by a seed.

Recordings of real arms stand beside the project or not at all; without them their cases are none.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from zlib import crc32

import numpy as np

from mukca import load_robot, read_placements, simulate_recordings
from mukca.recorder import Placement, read_table_placement
from mukca.solver.calibration import quaternion_of
from mukca.solver.identification.data import Pose
from mukca.solver.identification.robot import BallModel, Robot, shipped_robots, turn
from mukca.tools.simulation import Base, perturb

from . import TRANSLATION, TURN, measured_points, recorded_by_both
from .changes import CHANGES, Change, picked

SHARED = Path(__file__).resolve().parents[3] / "shared"
REAL = {
    "panda_1": "panda",
    "panda_3": "nominal.urdf",
    "kuka_14": "nominal.urdf",
    "dinova_1": "gen3_lite",
    "dinova_2": "nominal.urdf",
}
"""Folders of recordings of real arms, and the model of each."""
TRACKED = {
    "ur5": ("../ur5.urdf", "--flange", "tool0", "--ball", "0", "0", "0.031"),
    "ur10": ("ur10",),
}
"""Folders of what a laser tracker measured, and the model of each arm, with its ball."""
REAL_SOURCES = (
    *REAL,
    "panda_1 tested on panda_3",
    "dinova_2 tested on dinova_1",
    "panda_3 read as iiwa14",
    "tracked points of ur5",
    "tracked points of ur10",
    "tracked poses of ur10",
)
LONG_ARMS = ("panda", "fr3", "ur5", "ur5e", "ur10e", "iiwa14", "xarm7")
"""Of these any two reach the bases between them."""
SHARE_OF_REAL = 0.4
"""Of random cases."""
AS_IT_IS = "as it is"
NEAR = 2e-4
"""Standard deviation of links that are nearer to their model than the data can tell [m]."""
SOUND_SAMPLES = 15
"""In each socket of simulated recordings."""
FACING = Pose(turn(np.array([0.0, 0.0, np.pi])), np.array([1.2, 0.0, 0.0]))
BETWEEN = (
    Base("front", np.array([0.6, 0.0, 0.15]), np.array([1.0, 0.0, 0.0])),
    Base("left", np.array([0.55, 0.35, 0.3]), np.array([0.54, 0.84, 0.0])),
)
"""Where the second of two arms stands seen from the first, and the bases that both visit."""
KINDS = """
3 samples: ur5e, panda_3, so101
4 samples: xarm6, kuka_14, koch
5 samples: piper, panda_3, dinova_1
8 samples: lite6, dinova_2, openarm
15 samples: wx250s, panda_1, ur20
one socket nearly empty: ur10e, panda_3, iiwa14
one joint off by 0.2 rad: ur3e, kuka_14, fr3
3 mrad of noise: gen3_lite, panda_3, vx300s
as it is: ur5 near its model, dinova_1, panda near its model
6 samples: uf850 near its model, so100 near its model, xarm7 near its model
as it is: ur5e read as ur3e, panda_1 tested on panda_3, panda_3 read as iiwa14
rows repeated: ur3, panda_3, gen3
postures alike: wxai, kuka_14, so101
one posture: ur10, panda_3, xarm6
columns swapped, one sample far off: ur5e, dinova_2, uf850
3 samples: points of ur5e, tracked points of ur5, tracked poses of ur10
points of two markers: points of xarm6, tracked points of ur10, poses of panda
postures alike: points of ur3e, poses of ur5e, points of openarm
one socket nearly empty, 3 mrad of noise: so101, dinova_1, lite6
5 samples: ur5 and ur5e, panda and ur5e, ur10e and iiwa14
"""
"""Twenty kinds of awkward recordings, each of three sources, the first of which is the cheapest."""


@dataclass(frozen=True)
class Recorded:
    """Recordings of an arm, or of several by name: those trained on, and those held out."""

    robots: Mapping[str, str]
    """Name or URDF of each robot's model; one alone is called ``""``."""
    train: Mapping[str, Sequence[Placement]]
    test: Mapping[str, Sequence[Placement]]
    ball: Sequence[str] = ()
    """Options that put a ball on a model without any."""

    def robot(self, name: str = "") -> Robot:
        """Return the model of a robot, with its ball."""
        if not self.ball:
            return load_robot(self.robots[name])
        _, flange, _, *ball = self.ball
        return load_robot(
            self.robots[name], flange=flange, ball=[float(x) for x in ball]
        )

    def changed(self, change: Change, seed: int) -> "Recorded":
        """Return the recordings with a change of each placement."""

        def each(part: Mapping[str, Sequence[Placement]]) -> dict[str, list[Placement]]:
            # draws of one seed begin alike, so one joint or column is hit in all placements
            return {
                name: [change(one, np.random.default_rng(seed)) for one in placements]
                for name, placements in part.items()
            }

        return replace(self, train=each(self.train), test=each(self.test))


@dataclass(frozen=True)
class Case:
    """A case of the zoo: whose recordings, and the names of the changes that were made to them."""

    source: str
    changes: tuple[str, ...] = ()
    seed: int = 0

    @property
    def name(self) -> str:
        """Source and changes in words."""
        return f"{self.source}: {', '.join(self.changes) or AS_IT_IS}"

    @property
    def missing(self) -> bool:
        """True where recordings of real arms are needed and not there."""
        real = self.source.startswith("tracked ") or not REAL.keys().isdisjoint(
            self.source.split()
        )
        return real and not SHARED.is_dir()

    def recorded(self) -> Recorded:
        """Return the recordings, the same each time."""
        found = recorded_of(self.source, self.seed)
        for name in self.changes:
            found = found.changed(CHANGES[name], self.seed + crc32(name.encode()))
        return found


@lru_cache(maxsize=64)
def recorded_of(source: str, seed: int = 0) -> Recorded:
    """Return recordings of a source; of what has more placements, two that the seed chooses.

    A source is a folder of ``REAL``; ``tracked points`` or ``tracked poses of`` one of ``TRACKED``;
    a shipped robot, ``points`` or ``poses of`` it, or ``near its model``; two of them, ``A and B``;
    ``SOURCE read as ROBOT``, or ``SOURCE tested on SOURCE``.
    """
    first, other, second = source.partition(" tested on ")
    if other:
        return replace(recorded_of(first, seed), test=recorded_of(second, seed).test)
    recorder, read, model = source.partition(" read as ")
    if read:
        return replace(recorded_of(recorder, seed), robots={"": model})
    kind, _, robot = source.rpartition(" of ")
    if source in REAL:
        return _real(source, seed)
    if kind.startswith("tracked "):
        return _tracked(robot, kind.removeprefix("tracked "), seed)
    if kind:
        return _measured(robot, kind, seed)
    if " and " in source:
        return _side_by_side(source.split(" and "), seed)
    name, near, _ = source.partition(" near ")
    options = {"translation": NEAR, "rotation": 0.0} if near else {"translation": 1e-3}
    drawn = simulate_recordings(
        load_robot(name),
        2,
        samples=SOUND_SAMPLES,
        seed=seed % 3,
        compliance=3e-5,
        **options,
    )
    train, test = drawn[1]
    return Recorded({"": name}, {"": [train]}, {"": [test]})


def _real(arm: str, seed: int) -> Recorded:
    folder = SHARED / "recordings" / arm
    model = str(folder / REAL[arm]) if REAL[arm].endswith(".urdf") else REAL[arm]
    placements = read_placements(folder)
    train, test = np.random.default_rng(seed).permutation(len(placements))[:2].tolist()
    return Recorded({"": model}, {"": [placements[train]]}, {"": [placements[test]]})


def _tracked(arm: str, kind: str, seed: int) -> Recorded:
    folder = SHARED / "tracker" / arm
    placement = replace(read_table_placement(folder / f"{kind}.csv"), name=arm)
    placement = replace(placement, poses_of="flange" if kind == "poses" else None)
    rows = np.random.default_rng(seed).permutation(len(placement.samples)).tolist()
    train, test = (picked(placement, sorted(own)) for own in (rows[:60], rows[60:90]))
    model, *ball = TRACKED[arm]
    model = str((folder / model).resolve()) if model.endswith(".urdf") else model
    return Recorded({"": model}, *_named(train, test), ball)


def _measured(robot: str, kind: str, seed: int) -> Recorded:
    """Balls, or poses of the ball's link, that an instrument measured of a simulated arm."""
    generator = np.random.default_rng(seed % 3)
    arm = perturb(load_robot(robot), generator, TRANSLATION, TURN)
    frame = Pose(turn(generator.uniform(-2, 2, 3)), generator.uniform(-2, 2, 3))
    parts = [
        measured_points(arm, frame, generator, samples=30, noise=5e-5) for _ in range(2)
    ]
    if kind == "poses":
        parts = [_with_turns(part, arm, frame) for part in parts]
    return Recorded({"": robot}, *_named(*parts))


def _named(train: Placement, test: Placement) -> list[dict[str, list[Placement]]]:
    """Return both of a single robot, named by what they are for."""
    return [
        {"": [replace(placement, name=name, place=name, files=())]}
        for name, placement in (("train", train), ("test", test))
    ]


def _with_turns(placement: Placement, arm: Robot, frame: Pose) -> Placement:
    R = BallModel(arm, []).rotations(np.empty(0), placement.positions).points
    turns = quaternion_of(frame.rotation.T @ R).tolist()
    pairs = zip(placement.samples, turns, strict=True)
    samples = tuple(replace(s, orientation=(*turn,)) for s, turn in pairs)
    return replace(placement, samples=samples, poses_of="flange")


def _side_by_side(names: Sequence[str], seed: int) -> Recorded:
    generator = np.random.default_rng(seed % 3)
    arms = [perturb(load_robot(name), generator, TRANSLATION, TURN) for name in names]
    poses = Pose(np.eye(3), np.zeros(3)), FACING
    recorded = recorded_by_both(arms, poses, BETWEEN, generator, samples=8, noise=5e-5)
    train = {arm: [p[0]] for arm, p in zip("AB", recorded, strict=True)}
    test = {arm: [p[1]] for arm, p in zip("AB", recorded, strict=True)}
    return Recorded(dict(zip("AB", names, strict=True)), train, test)


def zoo() -> list[list[Case]]:
    """Return the kinds of awkward recordings, each of three cases."""
    kinds: list[list[Case]] = []
    for line in KINDS.strip().splitlines():
        changes, _, sources = line.partition(": ")
        names = () if changes == AS_IT_IS else tuple(changes.split(", "))
        kinds.append([Case(source, names) for source in sources.split(", ")])
    return kinds


def random_case(seed: int) -> Case:
    """Return a case of a random source with up to three random changes; the same by its seed."""
    generator = np.random.default_rng(seed)
    a, b = generator.choice([*shipped_robots()], 2).tolist()
    pair = " and ".join(generator.choice(LONG_ARMS, 2).tolist())
    sources = [
        a,
        f"{a} near its model",
        f"points of {a}",
        f"poses of {a}",
        f"{a} read as {b}",
        pair,
    ]
    if SHARED.is_dir() and generator.random() < SHARE_OF_REAL:
        sources = REAL_SOURCES
    changes = generator.choice([*CHANGES], generator.integers(4), replace=False)
    return Case(str(generator.choice(sources)), tuple(changes.tolist()), seed)
