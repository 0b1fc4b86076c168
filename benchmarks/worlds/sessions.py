"""Sessions of simulated arms beside their base, sound or with a fault, as a check looks at them.

An arm has realistic flaws, its ball mounted where the model does not have it, servo arms zeros off
by 5 degrees and play. The sockets are 100 mm apart, 12 + 12 samples in the order 0 1 0 1.
"""

import math
import os
from dataclasses import replace
from zlib import crc32

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from mukca.recorder import Placement, Sample
from mukca.solver.assessment import ARMS
from mukca.solver.diagnostics import LiveCheck
from mukca.solver.identification.robot import (
    Origin,
    Robot,
    angles_near,
    load_robot,
    rotation,
    rotation_rpy,
)
from mukca.tools.simulation import (
    Base,
    Imperfection,
    Session,
    SessionFault,
    lead,
    perturb,
    reachable_bases,
    with_faults,
)

from . import realistic_flaws

SERVOS = ("so100", "so101", "koch", "gen3_lite", "wx250s", "vx300s", "wxai")
MOUNT, ZEROS, PLAY = 0.03, math.radians(5), math.radians(0.5)
PLAYS = {"gen3_lite": 3e-3}
"""Of arms of which something is known, see ARMS [rad]."""
ORDER = np.repeat([0, 1, 0, 1], 6)


def arm_of(robot: Robot, generator: np.random.Generator) -> Robot:
    """Return an arm as it truly is: flawed, its ball mounted elsewhere, its zeros off."""
    servo = robot.name in SERVOS
    arm = perturb(robot, generator, 2e-3, 5e-3, zeros=servo)
    joints = []
    for joint in arm.joints:
        xyz, rpy = np.array(joint.origin.xyz), joint.origin.rpy
        if joint is arm.ball_joint:
            xyz = xyz + generator.uniform(-MOUNT, MOUNT, 3)
        elif joint.actuated and servo:
            R = rotation_rpy(rpy) @ rotation(
                joint.axis, generator.uniform(-ZEROS, ZEROS)
            )
            rpy = tuple(angles_near(np.array(R.full()), np.array(rpy)).tolist())
        joints.append(replace(joint, origin=Origin(tuple(xyz.tolist()), rpy)))
    return replace(arm, joints=tuple(joints))


class Setting:
    """An arm beside its base: what all its sessions share."""

    def __init__(self, name: str, seed: int) -> None:
        self.robot = load_robot(name)
        self.seed, generator = seed, np.random.default_rng([seed, 11])
        self.arm = arm_of(self.robot, generator)
        how = realistic_flaws(self.robot, generator)
        if name in SERVOS:
            how = Imperfection(
                3e-4, play=PLAYS.get(name, PLAY), resolution=math.tau / 4096
            )
        self._base: Base = reachable_bases(self.arm, generator, 1, 0.1)[0]
        self._read = lead(self.arm, np.array(self._base.sockets)[ORDER], generator, how)
        self.check = LiveCheck(
            self.robot, ARMS[name].repeatability if name in ARMS else None
        )

    def fault(self, text: str) -> tuple[SessionFault | None, Session]:
        """Return a fault, and the session that it comes to."""
        sockets, own = (
            np.array(self._base.sockets),
            crc32(f"{self.robot.name} {text}".encode()),
        )
        generator = np.random.default_rng([self.seed, own])
        session = Session(self.arm, self._read, ORDER, sockets, generator)
        return SessionFault.parse(text), session

    def samples(self, text: str) -> tuple[Sample, ...]:
        """Return the samples of a session with a fault."""
        fault, session = self.fault(text)
        read = with_faults(session, [fault]) if fault else self._read
        rows = zip(read.tolist(), ORDER.tolist(), strict=True)
        return tuple(Sample(tuple(q), k, number=i) for i, (q, k) in enumerate(rows, 1))

    def placement(self, samples: tuple[Sample, ...]) -> Placement:
        """Return samples as what is checked."""
        return Placement("here", samples, self.robot.joint_names, self._base.distance)

    def told(self, samples: tuple[Sample, ...]) -> list[str]:
        """Return the kinds that are told after some samples, the most probable first."""
        found = self.check.faults([self.placement(samples)])
        return [fault.hypothesis.name for fault in found]
