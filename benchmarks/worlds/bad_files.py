"""Bad files of the verbs that hold a calibration, and of `extract`: one row for each mistake.

Each mistake writes its file into a folder beside the calibration ``calibrated``, and returns the
words of the command.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import mukca

JOINTS = tuple(f"panda_joint{k}" for k in range(1, 8))
POSE = ("x", "y", "z", "roll", "pitch", "yaw")
VIEW = ("x", "y", "z", "qx", "qy", "qz", "qw")
Mistake = Callable[[Path], list[str]]


def written(file: Path, header: Sequence[str], rows: np.ndarray) -> Path:
    lines = [",".join(header), *(",".join(map(repr, row)) for row in rows.tolist())]
    file.write_text("\n".join(lines) + "\n")
    return file


def table(verb: str, header: Sequence[str], rows: np.ndarray, *words: str) -> Mistake:
    """Give a table to a verb."""

    def mistake(folder: Path) -> list[str]:
        file = written(folder / "table.csv", header, rows)
        return [verb, str(folder / "calibrated"), str(file), *words]

    return mistake


def replaced(verb: str, content: bytes, *words: str) -> Mistake:
    """Give a verb another calibration."""

    def mistake(folder: Path) -> list[str]:
        (folder / "calibrated" / "calibration.json").write_bytes(content)
        return [
            verb,
            str(folder / "calibrated"),
            *(word.format(folder=folder) for word in words),
        ]

    return mistake


def log(header: Sequence[str], rows: np.ndarray) -> Mistake:
    """Give a log to `extract`."""

    def mistake(folder: Path) -> list[str]:
        return [
            "extract",
            str(written(folder / "log.csv", header, rows)),
            "--robot",
            "panda",
        ]

    return mistake


def like(name: str, content: str, to: str) -> Mistake:
    """Export like a file of another program."""

    def mistake(folder: Path) -> list[str]:
        (folder / name).write_text(content)
        words = [
            "--to",
            to,
            "--like",
            str(folder / name),
            "--out",
            str(folder / "new" / name),
        ]
        return ["export", str(folder / "calibrated"), *words]

    return mistake


def views(count: int, *, turned: bool) -> np.ndarray:
    """Views by a camera on the flange, which is turned between them or not."""
    generator = np.random.default_rng(2)
    robot = mukca.load_robot("panda")
    q = (robot.lower + robot.upper) / 2 + generator.uniform(
        -0.3, 0.3, (count, 7)
    ) * turned
    quaternions = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
    return np.hstack([q, generator.uniform(0.2, 0.4, (count, 3)), quaternions])


STILL = np.tile([0.1, -0.4, 0.2, -2.0, 0.1, 1.7, 0.8], (400, 1))
TIMES = 0.02 * np.arange(400)[:, None]
NOISE = np.random.default_rng(3).normal(0, 1e-5, STILL.shape)
TOUCHES = STILL[:8] + np.random.default_rng(4).uniform(-0.3, 0.3, (8, 7))
TURNED = np.array([[0.4, 0.2, 0.4, 180.0, 0.0, 90.0]])
ON_ARM, CAMERA = ("handeye", (*JOINTS, *VIEW)), ("--camera", "on-arm")
FROM_TO = np.where(np.arange(400)[:, None] % 2 == 1, 0.5, 0.0)
MISTAKES: dict[str, Mistake] = {
    "command: roll, pitch, yaw in degrees": table("command", POSE, TURNED),
    "command: places in millimetres": table(
        "command", POSE, TURNED * [1e3, 1e3, 1e3, 0.017, 0, 0.017]
    ),
    "command: half a pose": table("command", VIEW[:6], TURNED),
    "command: inches": table("command", ("x [in]", "y [in]", "z [in]"), TURNED[:, :3]),
    "poses: --tool in millimetres": table(
        "poses", JOINTS, TOUCHES, "--tool", "0,0,120,0,0,0"
    ),
    "poses: --tool in degrees": table(
        "poses", JOINTS, TOUCHES, "--tool", "0,0,.1,0,0,90"
    ),
    "poses: joints in degrees": table("poses", JOINTS, np.degrees(TOUCHES)),
    "poses: another arm's joints": table(
        "poses", ("elbow_joint", "wrist_1_joint"), TOUCHES[:, :2]
    ),
    "tool: three touches three times": table(
        "tool", JOINTS, np.repeat(TOUCHES[:3], 3, axis=0)
    ),
    "tool: points in millimetres": table(
        "tool",
        (*JOINTS, "x", "y", "z"),
        np.hstack([TOUCHES, 100 * np.eye(3)[np.arange(8) // 3]]),
    ),
    "handeye: views that are not turned": table(
        *ON_ARM, views(12, turned=False), *CAMERA
    ),
    "handeye: poses of nothing": table(*ON_ARM, views(12, turned=True), *CAMERA),
    "handeye: matrices that are no turns": table(
        "handeye",
        (*JOINTS, "x", "y", "z", *(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))),
        np.hstack([views(12, turned=True)[:, :10], np.ones((12, 9))]),
        *CAMERA,
    ),
    "validate: a calibration nested without end": replaced(
        "validate", b"[" * 1_000_000, "{folder}/left"
    ),
    "validate: a calibration of 21 MB": replaced(
        "validate", b" " * 21_000_000, "{folder}/left"
    ),
    "validate: a calibration cut off": replaced(
        "validate", b'{"format": ', "{folder}/left"
    ),
    "export: another arm's YAML": like(
        "k.yaml", "kinematics:\n  forearm:\n    x: -0.4\n", "ur"
    ),
    "export: a MuJoCo model without this arm": like(
        "m.xml", "<mujoco><worldbody/></mujoco>", "mjcf"
    ),
    "export: lerobot's file of no motors": like("l.json", "{}", "lerobot"),
    "extract: degrees without a word": log(
        ("time", *JOINTS), np.hstack([TIMES, np.degrees(STILL)])
    ),
    "extract: no time": log(JOINTS, STILL),
    "extract: two arms": log(
        ("time", *(f"{arm}_{n}" for arm in ("a", "b") for n in JOINTS)),
        np.hstack([TIMES, STILL, STILL]),
    ),
    "extract: two publishers in turn": log(
        ("time", *JOINTS), np.hstack([TIMES, STILL + NOISE + FROM_TO])
    ),
    "extract: a log of one second": log(
        ("time", *JOINTS), np.hstack([TIMES, STILL])[:50]
    ),
    "extract: five states a second": log(
        ("time", *JOINTS), np.hstack([10 * TIMES, STILL])
    ),
}
