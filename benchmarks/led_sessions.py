"""How sessions end that a person leads by what the screen says, with faults that no text names.

    python benchmarks/led_sessions.py [--seeds 0 3] [--arms panda ...] [--faults base@13:5mm ...]
                                      [--most 40] [--keep FILE] [--processes 1]

A session goes by the recorder's own values: guidance, prompt, keys and files, all but the stream
and the drawn screen; its arms are those of ``worlds/sessions.py``. A hand leads the arm near
each proposed pose, captures, changes the socket where that is asked, presses the key that an alarm
offers first, and finishes at ENOUGH, NEXT PLACE or SOLVE FAILS, else after ``--most`` samples.
A fault is KIND[@SAMPLE[+COUNT]][:SIZE]; most are those of ``mock``, and

    arc@13:5mm    the base moves along the circle of joint 1
    same@9:5mm    the ball is pulled the same way at samples 9, 13 and 17
    reads@13      a joint reads 1.5 rad more than before
    near          all poses lie within 25 degrees of each other
    cell:10deg    joints 1 to 3 keep within 10 degrees of where they began
    tips@10+3:3mm the base is elsewhere for three samples, and falls back
    sign          a joint reads with the wrong sign
    slips@7:1deg  a joint reads up to 1 degree otherwise after every fourth sample

``--always-keep`` presses k at each alarm, whatever it offers first, in the sessions that ``--keep``
holds and in which another key came first.

Of each session are told: the first alarm and how many samples of the fault it took, the keys that
cured, the words at the end, the samples there by part, the verdict of ``mukca solve`` on them, and
the mean error of that calibration, and of the model, at another place of the base [mm].
"""

import argparse
import json
import os
import re
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any
from zlib import crc32

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from guide import Hand
from worlds import realistic_flaws
from worlds.sessions import PLAY, PLAYS, SERVOS, arm_of

from mukca.errors import MukcaError
from mukca.recorder import Metadata, Placement, Sample, read_placements
from mukca.recorder.session import (
    BLOCK,
    Advice,
    GuidanceClient,
    GuidanceRequest,
    Recording,
    Session,
    SessionActions,
    Sound,
    View,
)
from mukca.recorder.stream import StationaryPose
from mukca.recorder.terminal.key_handler import KeyHandler
from mukca.solver.assessment import repeatability_of
from mukca.solver.calibration import calibrate
from mukca.solver.diagnostics import is_coarse
from mukca.solver.identification.robot import Origin, Robot, load_robot
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.recording import PoseSelector, joints_of
from mukca.tools.simulation import Imperfection, lead, reachable_bases, record

DISTANCE = 0.1
LED = ("panda", "ur5e", "iiwa14", "xarm7", "gen3_lite", "so101")
FAULTS = (
    *("none", "base@13:3mm", "base@13:5mm", "arc@13:5mm", "ball@9:5mm", "same@9:5mm"),
    *("socket@13+3", "zero@10:1deg", "bent@10:5mm", "drift@7:5mm", "distance:2mm"),
    *("reads@13", "near", "cell:10deg", "tips@10+3:3mm", "bent@13:25mm"),
    *("distance:900mm", "sign", "slips@7:1deg"),
)
AGAIN = 4
"""Samples from one that is pulled to the next."""
SLOW = 20
"""Samples over which a base drifts by its size."""
SHARE = 3
"""Samples from one whole advice to the next."""
READS = 1.5
"""[rad]"""
WALLED = 3
"""First joints that a narrow cell holds."""
STUBBORN = 10
"""Poses in a row outside the limits after which a person gives up."""
LAST = ("ENOUGH", "NEXT PLACE", "SOLVE FAILS", "TARGET")
_TEXT = re.compile(r"([a-z]+)(?:@(\d+)(?:\+(\d+))?)?(?::([\d.]+)(mm|deg))?")


@dataclass
class Direct:
    """Guidance by a selector in this process: an answer is there when it was asked for.

    As for a quick hand, whole advice comes after every third sample, and alarms after each.
    """

    selector: PoseSelector
    trouble: str | None = None
    idle: bool = True
    advice: Advice | None = None

    def ask(self, request: GuidanceRequest) -> None:
        """Work out an answer."""
        count = len(request.samples)
        if count % SHARE and count > SHARE:
            alarms = self.selector.alarms(request.samples, request.answers)
            self.advice = Advice(
                count, request.socket, np.inf, 0.0, alarms=alarms, early=True
            )
            return
        self.advice = self.selector.advise(
            request.samples, request.socket, request.position, request.answers
        )

    def answer(self) -> Advice | None:
        """Return the answer once."""
        advice, self.advice = self.advice, None
        return advice


class World:
    """An arm as it truly is, its base, and a fault."""

    def __init__(self, name: str, seed: int, fault: str) -> None:
        self.robot, generator = load_robot(name), np.random.default_rng([seed, 23])
        self.arm = arm_of(self.robot, generator)
        self.flaws = realistic_flaws(self.robot, generator)
        if name in SERVOS:
            self.flaws = Imperfection(
                3e-4, play=PLAYS.get(name, PLAY), resolution=np.pi / 2048
            )
        self.base, self.elsewhere = reachable_bases(self.arm, generator, 2, DISTANCE)
        match = _TEXT.fullmatch(fault)
        self.kind, self.begin = match[1], int(match[2] or 1)
        self._count = int(match[3] or 1)
        unit = 1e-3 if match[5] == "mm" else np.deg2rad(1)
        self._size = float(match[4] or 0) * unit
        self.generator = np.random.default_rng([seed, crc32(fault.encode())])
        self.aside = self.generator.normal(size=3)
        self.aside *= self._size / np.linalg.norm(self.aside)
        self._first: np.ndarray | None = None

    @property
    def given(self) -> float:
        """The distance of the sockets as it is typed [m]."""
        return DISTANCE + self._size * (self.kind == "distance")

    def read(self, number: int, socket: int, aim: Sequence[float] | None) -> np.ndarray:
        """Return what the encoders read at a sample, by its number since the session began."""
        since = number >= self.begin
        arm = _bent(self.arm, self.aside) if since and self.kind == "bent" else self.arm
        hand = Hand(arm, self.generator, noise=0.0)
        hand.aim = None if aim is None else np.array(aim)
        hand.aim = self._first if self.kind == "near" else hand.aim
        if (
            hand.aim is not None
        ):  # as it reads, a hand leads it to what the screen shows
            hand.aim = self._true(hand.aim, number)
        if self.kind == "cell" and self._first is not None and hand.aim is not None:
            begin = self._first[:WALLED]
            low, high = begin - self._size, begin + self._size
            hand.aim[:WALLED] = np.clip(hand.aim[:WALLED], low, high)
        seat = self._seat(number, socket)
        (q,) = lead(arm, seat[None], self.generator, self.flaws, hand)
        self._first = q if self._first is None else self._first
        return self.as_read(q, number)

    def as_read(self, q: np.ndarray, number: int) -> np.ndarray:
        """Return what a sound arm would read, shape (.., m), as it is read at a sample."""
        q, joint, since = q.copy(), q.shape[-1] // 2, number >= self.begin
        q[..., joint] += since * self._size * (self.kind == "zero")
        q[..., joint] += since * READS * (self.kind == "reads")
        q[..., joint] *= -1 if self.kind == "sign" else 1
        if self.kind == "slips" and since:
            turns = np.random.default_rng((number - self.begin) // AGAIN)
            q[..., joint] += self._size * turns.uniform(-1, 1)
        return q

    def _true(self, reading: np.ndarray, number: int) -> np.ndarray:
        """Return how an arm stands that reads this, but for faults of a degree."""
        q, joint = reading.copy(), len(reading) // 2
        q[joint] -= READS * (self.kind == "reads" and number >= self.begin)
        q[joint] *= -1 if self.kind == "sign" else 1
        return q

    def _seat(self, number: int, socket: int) -> np.ndarray:
        """Return where the ball is at a sample [m]."""
        seat, away = self.base.sockets[socket], number - self.begin
        if self.kind == "socket" and 0 <= away < self._count:
            return self.base.sockets[1 - socket]
        if self.kind == "base" and away >= 0:
            return seat + self.aside
        if self.kind == "tips" and 0 <= away < self._count:
            return seat + self.aside
        if self.kind == "drift":
            return seat + self.aside * min(max(away / SLOW, 0), 1)
        if self.kind == "ball" and away == 0:
            return seat + self.aside
        if self.kind == "same" and away in (0, AGAIN, 2 * AGAIN):
            return seat + self.aside
        if self.kind == "arc" and away >= 0:
            radius = float(np.linalg.norm(self.base.centre[:2]))
            return seat + self._size * np.cross([0, 0, 1], seat) / radius
        return seat


def _bent(arm: Robot, aside: np.ndarray) -> Robot:
    """Return an arm whose ball sits elsewhere on its flange."""
    joints = [
        replace(
            joint,
            origin=Origin(tuple(np.add(joint.origin.xyz, aside)), joint.origin.rpy),
        )
        if joint is arm.ball_joint
        else joint
        for joint in arm.joints
    ]
    return replace(arm, joints=tuple(joints))


class Operator:
    """A person who does what the screen says, at one part of a session after the other."""

    def __init__(self, world: World, folder: Path, *, keeps: bool = False) -> None:
        self.world, self.folder = world, folder
        self.keeps = keeps
        self.captured = 0
        self.alarms: list[tuple[int, str]] = []
        self.cures: list[str] = []
        self.words = ""
        self.beyond = 0
        self.first = self.lost = 0
        self._begun = 0
        self._parts: list[Placement] = []
        self._begin_part(self._first_recording())

    def _first_recording(self) -> Recording:
        """Open the folder in which the session begins."""
        world = self.world
        robot = world.robot
        units = tuple(joint.unit for joint in joints_of(robot))
        about = Metadata(
            robot.name, robot.joint_names, units, world.given, measured=True
        )
        return Recording(self.folder / "part", about)

    def _begin_part(self, recording: Recording) -> None:
        """Go on in a folder, with the samples since the base moved."""
        world = self.world
        robot = world.robot
        self.recording = recording
        session = Session(
            joints_of(robot),
            samples=recording.content.samples,
            socket=recording.socket,
            distance=world.given,
            block=BLOCK,
        )
        sound = Sound(lambda: None, on=False)
        self.actions = SessionActions(session, self.recording, sound)
        selector = PoseSelector(robot, world.given, parts=self._parts, lost=self.lost)
        self.guidance = GuidanceClient(Direct(selector), self.actions, sound)
        self.handler = KeyHandler(self.actions, self.guidance, lambda: None)
        self.position: tuple[float, ...] | None = None

    def lead(self, most: int) -> None:
        """Go on until the screen says that it is over, or for so many samples."""
        pressed = 0
        while self.captured < most and pressed < 3 * most:
            pressed += 1
            self.guidance.update(self.position)
            self.guidance.update(self.position)
            prompt = self._view().prompt
            self.words, alarm = prompt.words, self.guidance.alarm
            if self.beyond == STUBBORN:
                self.words = "OUT OF LIMITS"
                break
            if alarm:
                self.alarms.append((self.captured, alarm.words))
                self._press("keep" if self.keeps else next(iter(alarm.answers)))
                if self.cures[-1] == "q":
                    self.words = alarm.words
                    break
            elif self.words in LAST:
                break
            elif "then press s" in prompt.reason:
                self.handler.press("s")
            else:
                self._capture()
        self.recording.close()

    def _press(self, action: str) -> None:
        """Press the key of an action that answers an alarm."""
        key = self.actions.session.key_names[action]
        self.cures.append(key)
        self.handler.press(key)
        if key == "m":  # a caliper reads what is true
            for letter in (*f"{1e3 * DISTANCE:g}", "Enter"):
                self.handler.press(letter)
        successor = self.actions.successor
        if successor:
            self._begun += 1
            self.recording.close()
            live = self.actions.session.live
            self._parts += [self._placement(live)] if live else []
            if successor.metadata.readings_changed:
                self.lost += sum(len(part.samples) for part in self._parts)
                self._parts = []
                self.first = self._begun
            self._begin_part(successor)

    def _capture(self) -> None:
        session, advice = self.actions.session, self.guidance.advice
        aim = advice.target if advice else None
        q = tuple(self.world.read(self.captured + 1, session.socket, aim).tolist())
        self.position = q
        if refusal := session.refusal(q):
            self.beyond += "outside its limits" in refusal
            return
        self.beyond = 0
        self.captured += 1
        self.actions.capture(StationaryPose(q, (0.0,) * len(q), None, None, 0.0, 1))

    def _placement(self, samples: Sequence[Sample]) -> Placement:
        names = self.world.robot.joint_names
        return Placement(
            self.recording.folder.name, tuple(samples), names, self.world.given
        )

    def _view(self) -> View:
        session, client = self.actions.session, self.guidance
        position = self.position or (0.0,) * len(session.joints)
        return View(session, position, advice=client.advice, alarm=client.alarm)


def led(most: int, keeps: bool, job: tuple[str, int, str]) -> dict[str, Any]:
    """Lead one session, solve it, and return its row."""
    name, seed, fault = job
    world = World(name, seed, fault)
    with tempfile.TemporaryDirectory() as folder:
        operator = Operator(world, Path(folder), keeps=keeps)
        operator.lead(most)
        parts = read_placements(Path(folder)) if operator.captured else []
        parts = parts[operator.first :]
        counts = [np.bincount(part.sockets, minlength=2).tolist() for part in parts]
        row = {
            "arm": name,
            "seed": seed,
            "fault": fault,
            "keeps": keeps,
            "captured": operator.captured,
            "alarms": operator.alarms,
            "cures": operator.cures,
            "end": operator.words,
            "counts": counts,
        }
        return {**row, **_solved(world, parts, operator.captured)}


def _solved(world: World, parts: Sequence[Placement], last: int) -> dict[str, Any]:
    """Return the verdict of a solving, and the errors of its calibration and of the model [mm].

    They are those of the arm as it reads at the last sample.
    """
    generator = np.random.default_rng(7)
    arm = world.arm
    if not parts:
        return {"verdict": "nothing captured", "error": None, "nominal": None}
    if world.kind == "bent":  # the ball that is on it in the end
        arm = _bent(arm, world.aside)
    test = record(arm, world.elsewhere, generator, samples=15, imperfection=world.flaws)
    test = test.with_positions(world.as_read(test.positions, last))
    zeros = is_coarse(repeatability_of(world.robot, None)) or None
    try:
        verdict = calibrate(world.robot, parts, zeros=zeros).verdict
        solved = calibrate(
            world.robot, parts, zeros=zeros, test=[test]
        ).errors.summary.test
    except MukcaError as error:
        return {"verdict": f"refused: {error}", "error": None, "nominal": None}
    assert solved
    errors = [
        1e3 * of.mean_absolute_error for of in (solved.calibrated, solved.nominal)
    ]
    return {"verdict": verdict.title, "error": errors[0], "nominal": errors[1]}


def lines_of(rows: Sequence[dict[str, Any]], faults: Sequence[str]) -> Iterator[str]:
    """Yield the rows of the table, by fault."""
    for fault in faults:
        for row in (row for row in rows if row["fault"] == fault):
            first = next((at for at, _ in row["alarms"]), None)
            begin = int(_TEXT.fullmatch(fault)[2] or 1)
            late = "never" if first is None else f"{first - begin + 1}"
            words = row["alarms"][0][1] if row["alarms"] else "-"
            parts = " ".join(f"{a}+{b}" for a, b in row["counts"])
            sizes = (
                "-"
                if row["error"] is None
                else f"{row['error']:.2f} ({row['nominal']:.1f})"
            )
            yield (
                f"{fault:<13} {row['arm']:<10} {words:<13} {late:>5}  "
                f"{''.join(row['cures']) or '-':<8} {row['end']:<12} {parts:<14} "
                f"{row['verdict'][:32]:<32} {sizes}"
            )


def kept_by(
    most: int, keeps: bool, keep: Path | None, job: tuple[str, int, str]
) -> dict[str, Any]:
    """Lead one session, and keep its row."""
    row = led(most, keeps, job)
    if keep:
        with keep.open("a") as file:
            file.write(json.dumps(row) + "\n")
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--seeds", type=int, nargs=2, default=(0, 3), help="first, and how many"
    )
    parser.add_argument("--arms", nargs="+", default=LED)
    parser.add_argument("--faults", nargs="+", default=FAULTS)
    parser.add_argument("--most", type=int, default=40, help="samples of a session")
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--always-keep", action="store_true", help="k at each alarm")
    add_options(parser, WorkerOptions)
    a = parser.parse_args()
    kept = a.keep.read_text().splitlines() if a.keep and a.keep.exists() else []
    rows: list[dict[str, Any]] = [json.loads(line) for line in kept]
    cured = {
        (row["arm"], row["seed"], row["fault"])
        for row in rows
        if not row["keeps"] and set(row["cures"]) - {"k"}
    }
    rows = [row for row in rows if row["keeps"] == a.always_keep]
    there = {(row["arm"], row["seed"], row["fault"]) for row in rows}
    seeds = range(a.seeds[0], sum(a.seeds))
    # an arm each: with more seeds every fault meets every arm
    jobs = [
        (a.arms[(i + s) % len(a.arms)], s, f)
        for s in seeds
        for i, f in enumerate(a.faults)
    ]
    if a.always_keep:
        jobs = [job for job in jobs if job in cured]
    new = [job for job in jobs if job not in there]
    rows += read_options(a).workers.map(
        partial(kept_by, a.most, a.always_keep, a.keep), new
    )
    print("fault         arm        first alarm  after  keys     end          samples        "
          "solve                            error (model) [mm]")  # fmt: skip
    print("\n".join(lines_of(rows, a.faults)))


if __name__ == "__main__":
    main()
