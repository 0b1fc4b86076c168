"""A servo arm with play and coarse encoders: are its zeros found, and what is left of its errors?

::

    python benchmarks/servo_arm.py [--arms 12] [--samples 20] [--play 0.7] [--angles 0] [--seed 0]

An SO-101 whose zeros are off by up to 5 degrees and whose lengths by 0.3 mm, with 0.7 degrees of
play in each joint, which rests where gravity turns it to, and encoders of 0.088 degrees. One
placement of 2 x 20 configurations in a base whose place on the arm's own base is known to 0.3 mm;
another placement, whose place is known as well, is held out. Printed are how far the ball is from
where the model puts it there, and for each joint how far the zero that was found is off, with its
stated deviation; then how many the data decide, how far these and all are off, and how many are
within one and two of their deviations. The roll's zero needs to know where the ball is in the
gripper, and is never decided.
"""

import argparse
import math
import os
import time
from dataclasses import replace
from functools import partial

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MUKCA_CHECK_COVARIANCES", "1")

import numpy as np

from mukca.solver.identification import FitOptions, fit
from mukca.solver.identification.data import (
    STANDARD_LOAD,
    SocketAt,
    measure,
    places_of,
)
from mukca.solver.identification.effects import JOINT_OFFSET
from mukca.solver.identification.inference import with_joint_offsets as zeros_in
from mukca.solver.identification.robot import (
    Origin,
    Robot,
    angles_near,
    choose_parameters,
    load_robot,
    rotation,
    rotation_rpy,
)
from mukca.solver.identification.selection import DECIDED
from mukca.solver.results import CalibratedRobot
from mukca.solver.studies import project_to_geometry
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import Base, Imperfection, perturb, reachable_bases, record

TICK = 2 * math.pi / 4096
LARGEST = math.radians(5)
ANCHORED = Base(
    "anchored", np.array([0.25, 0.0, 0.03]), np.array([0.7, 0.714, 0.0]), 0.15
)
BASE_KNOWN = 3e-4  # m: a base clipped to the arm's own


def with_joint_offsets(arm: Robot, zeros: np.ndarray) -> Robot:
    """Return the arm whose joints stand at q + zero where they read q."""
    left = iter(zeros)
    joints = []
    for joint in arm.joints:
        if joint.actuated:
            R = rotation_rpy(joint.origin.rpy) @ rotation(joint.axis, next(left))
            roll, pitch, yaw = angles_near(
                np.array(R.full()), np.array(joint.origin.rpy)
            ).tolist()
            joint = replace(joint, origin=Origin(joint.origin.xyz, (roll, pitch, yaw)))
        joints.append(joint)
    return replace(arm, joints=tuple(joints))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--robot", default="so101")
    parser.add_argument("--arms", type=int, default=12)
    parser.add_argument("--samples", type=int, default=20)
    parser.add_argument("--play", type=float, default=0.7, help="degrees")
    parser.add_argument(
        "--angles", type=float, default=0.0, help="of the origins, deviation [rad]"
    )
    parser.add_argument("--seed", type=int, default=0)
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    seeds = range(arguments.seed, arguments.seed + arguments.arms)
    arms = read_options(arguments).workers.map(partial(one_arm, arguments), seeds)
    print("\n".join(text for text, _ in arms))
    rows = np.concatenate([zeros for _, zeros in arms])
    decided = rows[rows[:, 1] <= math.degrees(DECIDED)]
    for name, some in (("all", rows), ("decided", decided)):
        off, ratio = np.abs(some[:, 0]), np.abs(some[:, 0] / some[:, 1])
        within = (
            [f"{100 * np.mean(ratio < k):.0f} %" for k in (1, 2)]
            if len(some)
            else ["-", "-"]
        )
        print(
            f"{name}: {len(some)} zeros, off by up to {off.max(initial=0):.2f} deg, "
            f"{(off > 0.4).sum()} by more than 0.4; up to {ratio.max(initial=0):.1f} of their "
            f"deviations, {within[0]} within one and {within[1]} within two"
        )


def one_arm(arguments: argparse.Namespace, seed: int) -> tuple[str, np.ndarray]:
    """Simulate and calibrate one arm.

    Returns:
        What to print; and of each joint's zero by how much it is off, and its stated deviation,
        shape (m, 2) [deg].
    """
    generator = np.random.default_rng(seed)
    nominal = load_robot(arguments.robot)
    zeros = generator.uniform(-LARGEST, LARGEST, len(nominal.actuated))
    arm = with_joint_offsets(perturb(nominal, generator, 3e-4, arguments.angles), zeros)
    how = Imperfection(noise=3e-4, play=math.radians(arguments.play), resolution=TICK)
    bases = [ANCHORED, *reachable_bases(arm, generator, 1)]
    placements = [
        record(arm, base, generator, samples=arguments.samples, imperfection=how)
        for base in bases
    ]
    train, test = (measure(placement, nominal) for placement in placements)
    at = [
        SocketAt(
            "base",
            (train.name, k),
            tuple(generator.normal(centre, BASE_KNOWN)),
            BASE_KNOWN,
        )
        for k, centre in enumerate(bases[0].sockets)
    ]
    parameters = tuple(choose_parameters(nominal))
    places = places_of([train], sockets_at=at)
    begin = time.perf_counter()
    posterior = fit(
        nominal,
        [train],
        FitOptions(parameters=parameters, places=places, zeros=True),
    )
    seconds = time.perf_counter() - begin
    full = posterior.arm
    urdf = project_to_geometry(full, STANDARD_LOAD)
    found = CalibratedRobot(
        nominal,
        parameters,
        zeros_in(full),
        full.deflection.without(JOINT_OFFSET.name),
        STANDARD_LOAD,
        urdf,
    )
    models = (found.nominal_ball, found.geometric_ball, found.ball)
    where = np.repeat(bases[1].sockets, arguments.samples, axis=0)
    errors = [
        np.linalg.norm(model(test.positions) - where, axis=1).mean() for model in models
    ]
    lines = [
        f"arm {seed} ({seconds:.1f} s), mm held out, nominal > URDF > corrected: "
        + " > ".join(f"{1e3 * error:.1f}" for error in errors),
        "  " + "; ".join(posterior.notes),
    ]
    begin = full.model.geometry
    deviations = np.degrees(
        np.sqrt(np.diag(full.covariance)[begin : begin + len(zeros)])
    )
    off = np.degrees(full.deflection.joint_offsets - zeros)
    for joint, one, deviation in zip(nominal.joint_names, off, deviations, strict=True):
        word = "decided" if deviation <= math.degrees(DECIDED) else "unknown"
        lines.append(f"  {joint:14} {word}, off {one:+.2f} deg +- {deviation:.2f}")
    return "\n".join(lines), np.column_stack([off, deviations])


if __name__ == "__main__":
    main()
