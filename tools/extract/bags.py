"""Logs of other programs: bags of ROS 1 and 2, by the package rosbags, and data sets of lerobot.

Data sets of versions 2.1 and 3.0 hold what the joints of the arm read, frame after frame. Their
units are not recorded, so the user says them. Degrees are those of lerobot: ticks of the servo
from the middle of its range, of which it counts 4095 a turn where the servo has 4096. Without
degrees, values run from -100 to 100 over the range that the calibration file of the arm holds.
"""

import re
from collections.abc import Callable
from itertools import chain
from pathlib import Path
from typing import Any, cast

import numpy as np

from ...drivers.arms.servos import read_lerobot
from ...errors import read_json, reason_of, require_file
from .log import (
    ExtractError,
    Log,
    Question,
    check_angles,
    columns_of,
    in_parts,
    needed_columns,
    refuse_normalised,
    require_angles,
    require_rate,
    unknown_joints,
)
from .topics import JointMessages, JointStates, chosen_topic
from .unpacking import bound_chunks, require_bounded, require_few_numbers

SINGLE = 1.0
"""Typical step of states from which a bag holds single poses [s]."""


def read_bag(question: Question) -> Log:
    """Return the joint states of a bag."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore

        unpack = bound_chunks()
    except ImportError:
        raise ExtractError("bags need rosbags: pip install 'mukca[bags]'") from None
    entries = question.path.glob("*") if question.path.is_dir() else [question.path]
    files = [file for file in entries if not file.is_dir()]
    for file in files:
        require_file(file, largest=None)
    store = get_typestore(Stores.ROS2_HUMBLE)
    try:
        for file in files:
            require_bounded(file)
        with AnyReader([question.path], default_typestore=store) as reader:
            topics = _topics(reader, question, unpack)
    except ExtractError as error:
        raise ExtractError(f"{question.path}: {error}") from None
    except Exception as error:  # whatever the reader stumbles over, the bag is to blame
        words = " ".join(str(error).split()) or type(error).__name__
        raise ExtractError(f"{question.path}: not a whole bag: {words}") from None
    return _log(topics, question)


def _topics(
    reader: Any, question: Question, unpack: Callable[[bytes], bytes]
) -> dict[str, JointMessages]:
    """Return the numbers of all messages that may be asked for, by topic."""
    sensors = [c for c in reader.connections if c.msgtype.endswith("/JointState")]
    connections = [c for c in sensors if question.topic in (None, c.topic)]
    if not connections:
        there = {f"{c.topic} ({c.msgtype})" for c in sensors or reader.connections}
        on_topic = f" on {question.topic}" if question.topic else ""
        listed = ", ".join(sorted(there)) or "nothing"
        if re.search("/(Pose|Transform|TF)", listed):
            listed += ": poses do not tell how the joints stood; record joint states"
        raise ExtractError(f"no sensor_msgs/JointState{on_topic}; it has {listed}")
    storages = [file.storage for file in reader.readers if reader.is2]
    packed = any(s.metadata.compression_mode == "message" for s in storages)
    for storage in storages:  # so that messages come as they are, and are unpacked here
        storage.metadata = storage.metadata._replace(compression_mode=None)
    topics: dict[str, JointMessages] = {}
    for connection, time, raw in reader.messages(connections=connections):
        data = unpack(raw) if packed else raw
        message = reader.deserialize(data, connection.msgtype)
        new = JointMessages(efforts=question.efforts)
        topics.setdefault(connection.topic, new).add(message, time)
    return topics


def _log(topics: dict[str, JointMessages], question: Question) -> Log:
    """Return the states of the topic that says what was measured.

    All names of a topic tell which are the model's joints: one message alone does not show that
    another has a second arm.
    """
    states_of_topics: dict[str, JointStates] = {}
    for name, topic in topics.items():
        columns = columns_of(topic.names, question)
        states = topic.states([topic.names[i] for i in columns or ()])
        if columns and len(states.stamps):
            states_of_topics[name] = states
    if not states_of_topics:
        names = chain.from_iterable(topic.names for topic in topics.values())
        raise unknown_joints(list(dict.fromkeys(names)), question)
    best, choice = chosen_topic(states_of_topics, question)
    states = states_of_topics[best]
    remarks = [f"read {best}, {len(states.stamps)} states", *states.remarks, *choice]
    positions = _in_radians(states.positions, question)
    efforts = states.efforts if question.efforts else None
    if efforts is not None and not np.isfinite(efforts).all():
        efforts = None
        remarks.append("its messages have no efforts, or not always")
    log = in_parts(states.stamps, positions, efforts, remarks)
    single = "of single poses make a table, and of that a recording by mukca convert"
    require_rate(log, question, single, SINGLE)
    return log


def _in_radians(positions: np.ndarray, question: Question) -> np.ndarray:
    """Return positions in radians; in ROS they are, but for drivers that publish degrees.

    Raises:
        ExtractError: They are of another unit than what is said of them.
    """
    require_angles(question, "a bag")
    degrees = question.units == "degrees"
    angles = positions * np.where(question.turning & degrees, np.radians(1.0), 1.0)
    check_angles(angles, degrees, question)
    return angles


INFO = Path("meta") / "info.json"
STATE = "observation.state"
VERSIONS = ("v2.0", "v2.1", "v3.0")
SERVO_ARMS = re.compile(r"so10|so_|koch|omx|lekiwi|moss", re.I)
"""Types of robots whose degrees come from ticks of 4095 a turn."""
TICK = 2 * np.pi / 4096
"""The step of such an arm's encoders [rad]."""


def read_lerobot_log(question: Question) -> Log:
    """Return the joint states of all episodes of a data set, each a part of its own."""
    info = _info(question.path)
    names = _names(info, question)
    columns = needed_columns(names, question)
    motors = [names[i] for i in columns]
    values, stamps, episodes = _table(question)
    positions, usable = _radians(values[:, columns], motors, info, question)
    order = np.lexsort((stamps, episodes))
    order = order[usable[order]]
    fps = info.get("fps")
    rate = f" at {fps:g} a second" if isinstance(fps, int | float) else ""
    count = len(np.unique(episodes))
    notes = [f"read {count} episodes, {len(stamps)} frames{rate}"]
    if clipped := len(stamps) - len(order):
        notes.append(
            f"{clipped} frames have a joint at the end of its range, and are left out"
        )
    return Log(
        stamps[order].astype(float),
        positions[order],
        None,
        episodes[order].astype(int),
        tuple(notes),
        resolution=TICK if SERVO_ARMS.search(str(info.get("robot_type"))) else 0.0,
        episodes=True,
    )


def _info(folder: Path) -> dict[str, Any]:
    try:
        info: Any = read_json(folder / INFO)
    except (OSError, ValueError) as error:
        raise ExtractError(
            f"{folder / INFO}: cannot be read: {reason_of(error)}"
        ) from None
    content = cast("dict[str, Any]", info) if isinstance(info, dict) else {}
    version = content.get("codebase_version")
    if version not in VERSIONS:
        raise ExtractError(
            f"{folder / INFO}: a data set of version {version}; {', '.join(VERSIONS)} can be read"
        )
    return content


def _names(info: dict[str, Any], question: Question) -> list[str]:
    """Return the data set's names of the numbers of a state."""
    try:
        names: Any = info["features"][STATE]["names"]
        while isinstance(names, dict):  # {"motors": [...]} in older ones
            names = next(iter(cast("dict[str, Any]", names).values()))
        return [str(n).removesuffix(".pos").removeprefix("main_") for n in names]
    except (KeyError, TypeError, StopIteration):
        raise ExtractError(
            f"{question.path / INFO}: features has no {STATE} with names: no joint states"
        ) from None


def _table(question: Question) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the states, their times, and their episodes."""
    try:
        from pyarrow import ArrowException, parquet
    except ImportError:
        raise ExtractError(
            "lerobot data sets need pyarrow: pip install 'mukca[lerobot]'"
        ) from None
    files = sorted((question.path / "data").rglob("*.parquet"))
    if not files:
        raise ExtractError(
            f"{question.path / 'data'}: no parquet files; is it all downloaded?"
        )
    parts: list[tuple[np.ndarray, ...]] = []
    keys = (STATE, "timestamp", "episode_index")
    for file in files:
        try:
            require_file(file, largest=None)
            require_few_numbers(file, parquet.read_metadata(file))
            table = parquet.read_table(file, columns=[*keys])
            states, *times = [table[key].to_numpy() for key in keys]
            parts.append((np.stack(states).astype(float), *times))
        except (ArrowException, OSError, KeyError, ValueError) as error:
            words = " ".join(str(error).split())
            raise ExtractError(
                f"{file}: not a whole table of states: {words}"
            ) from None
    states, stamps, episodes = map(np.concatenate, zip(*parts, strict=True))
    return states, stamps, episodes


def _radians(
    values: np.ndarray, names: list[str], info: dict[str, Any], question: Question
) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions in radians, and which states can be used."""
    known = np.all(np.isfinite(values), axis=1)
    if question.units in ("radians", "degrees"):
        degrees = question.units == "degrees"
        angles = values
        if degrees:
            refuse_normalised(values[known], question)
            angles = np.radians(values)
            if SERVO_ARMS.search(str(info.get("robot_type"))):
                angles = angles * 4095 / 4096
        check_angles(angles[known], degrees, question)
        return angles, known
    if question.units is None:
        raise ExtractError(
            f"{question.path}: a data set does not say its units: give --units degrees, or "
            "--units FILE, the arm's calibration file, for values from -100 to 100"
        )
    motors = read_lerobot(Path(question.units))
    absent = [name for name in names if name not in motors]
    if absent:
        raise ExtractError(f"{question.units}: no motor is called {', '.join(absent)}")
    if np.abs(values).max(initial=0.0) > 100 + 1e-6:
        raise ExtractError(f"{question.path}: values beyond 100; say --units degrees")
    # A value is one of 100 parts of half a motor's range.
    by_joint = [motors[name] for name in names]
    ranges = [motor.range_max - motor.range_min for motor in by_joint]
    signs = [-1 if motor.drive_mode else 1 for motor in by_joint]
    scale = np.array(signs) * ranges / 2 * TICK / 100
    inside = np.all(np.abs(values) < 100 - 1e-6, axis=1)
    return values * scale, known & inside
