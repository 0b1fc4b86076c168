"""Bags of all kinds, written by rosbags itself from a simulated session."""

import json
import tracemalloc

import numpy as np
import pytest

import mukca
from mukca.recorder.stream import JointLimits
from mukca.tools.extract import Question, find_rests, read_log, unpacking

rosbags = pytest.importorskip("rosbags", reason="the extra bags is not installed")

from rosbags.rosbag1 import Writer as Writer1  # noqa: E402
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin  # noqa: E402
from rosbags.rosbag2 import Writer as Writer2  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

pytestmark = pytest.mark.slow

NAMES = tuple(f"panda_joint{i}" for i in range(1, 8))
START = 1_700_000_000
TYPE = "sensor_msgs/msg/JointState"


class Bag:
    """Writes joint states into a bag of any kind, compressed or not."""

    def __init__(self, path, kind, compression=None):
        self.ros1 = kind == "bag"
        self.types = get_typestore(Stores.ROS1_NOETIC if self.ros1 else Stores.ROS2_HUMBLE)
        plugin = {"db3": StoragePlugin.SQLITE3, "mcap": StoragePlugin.MCAP}
        self.writer = (
            Writer1(path) if self.ros1 else Writer2(path, version=9, storage_plugin=plugin[kind])
        )
        if self.ros1 and compression:
            self.writer.set_compression(Writer1.CompressionFormat[compression])
        elif compression:
            self.writer.set_compression(CompressionMode[compression], CompressionFormat.ZSTD)
        self.writer.open()
        self.topics = {}

    def topic(self, name, type_=TYPE):
        if name not in self.topics:
            self.topics[name] = self.writer.add_connection(name, type_, typestore=self.types)
        return self.topics[name]

    def write(self, topic, stamp, names, position, effort=(), header=True, later=0.0, frame=""):
        known = self.types.types
        nanoseconds = round((START + stamp) * 1e9) if header else 0
        time = known["builtin_interfaces/msg/Time"](*divmod(nanoseconds, 1_000_000_000))
        head = known["std_msgs/msg/Header"]
        header_ = head(seq=0, stamp=time, frame_id=frame) if self.ros1 else head(time, frame)
        message = known[TYPE](
            header_, list(names), np.array(position, float), np.zeros(0), np.array(effort, float)
        )
        serialize = self.types.serialize_ros1 if self.ros1 else self.types.serialize_cdr
        connection = self.topic(topic)
        moment = round((START + stamp + later + 0.003) * 1e9)
        self.writer.write(connection, moment, serialize(message, TYPE))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.writer.close()


def busy_bag(path, kind, moves):
    """A bag as a lab's: grippers, another arm, names in another order, half messages."""
    with Bag(path, kind) as bag:
        shuffled = [3, 6, 0, 1, 5, 4, 2]
        for i, state in enumerate(moves.states):
            names = [NAMES[k] for k in shuffled] + ["panda_finger_joint1"]
            position = [state.position[k] for k in shuffled] + [0.04]
            if i % 7 == 0:  # another publisher on the same topic, and in another order
                names, position = names[::-1], position[::-1]
            bag.write("/joint_states", state.stamp, names, position, [0.1] * 8)
            if i % 5 == 0:
                bag.write("/joint_states", state.stamp + 1e-3, ["panda_finger_joint1"], [0.04])
                bag.write("/joint_states", state.stamp + 2e-3, NAMES[:5], state.position[:5])
            if i % 10 == 0:  # the same, now and then, on a topic of its own
                bag.write("/franka/joint_states", state.stamp, NAMES, state.position)


@pytest.mark.parametrize("kind", ["bag", "db3", "mcap"])
def test_every_rest_of_a_busy_bag_is_found(extract, moves, tmp_path, kind):
    path = tmp_path / ("session.bag" if kind == "bag" else "session")
    busy_bag(path, kind, moves)
    path = next(path.glob("*.mcap")) if kind == "mcap" else path
    out = tmp_path / "recordings"
    status, shown, err = extract(path, "--robot", "panda", "--out", out)
    assert status == 0, err
    assert "read /joint_states" in shown and "/franka/joint_states" in shown
    assert "lack a joint" in shown and "Look at the picture" in shown
    placement = moves.read_back(out / "placement_1")
    assert placement.joint_names == NAMES and placement.distance == 0.05
    assert placement.efforts is None
    svg = (out / "rests.svg").read_text()
    assert svg.count("<rect") == len(moves.places) and "panda_joint7" in svg


def test_two_arms_in_one_message(extract, refused, moves, tmp_path):
    with Bag(tmp_path / "two", "db3") as bag:
        names = [f"{side}_{name}" for name in NAMES for side in ("right", "left")]
        for state in moves.states:
            both = [value for left in state.position for value in (-left, left)]
            bag.write("/joint_states", state.stamp, names, both, header=False)
    refused("--joints 'right_*'", "extract", tmp_path / "two", "--robot", "panda")
    words = ("--joints", "left_*", "--out", tmp_path / "out")
    assert extract(tmp_path / "two", "--robot", "panda", *words)[0] == 0
    count = sum(socket is not None for socket in moves.sockets)
    assert len(mukca.read_placements(tmp_path / "out" / "placement_1")[0].samples) == count


def test_efforts_are_taken_when_they_are_torques(extract, moves, tmp_path):
    with Bag(tmp_path / "one", "db3") as bag:
        for state in moves.states[:1500]:
            bag.write("/joint_states", state.stamp, NAMES, state.position, np.arange(7.0))
    words = ("--efforts", "--out", tmp_path / "out")
    assert extract(tmp_path / "one", "--robot", "panda", *words)[0] == 0
    efforts = mukca.read_placements(tmp_path / "out" / "placement_1")[0].efforts
    assert efforts is not None and np.allclose(efforts, np.arange(7.0))


COMPRESSED = [
    ("bag", "BZ2"),
    ("bag", "LZ4"),
    ("mcap", "STORAGE"),
    ("db3", "MESSAGE"),
    ("mcap", "MESSAGE"),
    ("db3", "FILE"),
]


@pytest.mark.parametrize(("kind", "compression"), COMPRESSED)
def test_a_compressed_bag_is_read_like_another(tmp_path, kind, compression):
    path = tmp_path / ("session.bag" if kind == "bag" else "session")
    with Bag(path, kind, compression) as bag:
        for t, q in moving():
            bag.write("/joint_states", t, NAMES, q)
    log = read_log(question_of(path))
    assert np.array_equal(log.positions, [q for _, q in moving()])


@pytest.mark.parametrize(("kind", "compression"), COMPRESSED)
def test_what_unpacks_to_more_than_a_bag_does_is_refused_at_once(
    tmp_path, monkeypatch, kind, compression
):
    path, most = tmp_path / ("session.bag" if kind == "bag" else "session"), 2_000_000
    for name in ("LARGEST_CHUNK", "LARGEST_BAG"):
        monkeypatch.setattr(unpacking, name, most)
    with Bag(path, kind, compression) as bag:
        bag.write("/joint_states", 0.0, NAMES, [0.1] * 7, frame=20 * most * "\0")
    tracemalloc.start()
    with pytest.raises(mukca.MukcaError, match=r"session.*: .* unpack to more than 2 MB"):
        read_log(question_of(path))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 4 * most


def test_numbers_are_kept_and_not_messages(tmp_path):
    path, count = tmp_path / "session", 4000
    with Bag(path, "mcap") as bag:
        for i in range(count):
            bag.write("/joint_states", 0.01 * i, NAMES, 1e-3 * (np.arange(7.0) + i))
    read_log(question_of(path))  # modules and types are loaded
    tracemalloc.start()
    read_log(question_of(path))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 600 * count + 2_000_000


def write_other(path):
    with Bag(path, "db3") as bag:
        types = bag.types
        text = types.types["std_msgs/msg/String"]("hello")
        connection = bag.topic("/chatter", "std_msgs/msg/String")
        bag.writer.write(connection, 1, types.serialize_cdr(text, "std_msgs/msg/String"))


def write_names(path):
    with Bag(path, "db3") as bag:
        bag.write("/joint_states", 0.0, ["shoulder", "elbow"], [0.1, 0.2])


def write_torn(path):
    with Bag(path, "mcap") as bag:
        for i in range(2000):
            bag.write("/joint_states", 0.02 * i, NAMES, [0.1] * 7)
    file = next(path.glob("*.mcap"))
    file.write_bytes(file.read_bytes()[:5000])


def write_empty(path):
    path.mkdir()
    (path / "session.db3").touch()


@pytest.mark.parametrize(
    ("write", "said"),
    [
        (write_other, "no sensor_msgs/JointState; it has /chatter (std_msgs/msg/String)"),
        (write_names, "it has shoulder, elbow; name them in chain order by --joints"),
        (write_torn, "not a whole bag"),
        (write_empty, "nothing that can be read"),
        (lambda path: None, "no such file"),
    ],
)
def test_a_bag_that_cannot_be_used_gets_one_line(refused, tmp_path, write, said):
    path, out = tmp_path / "bag", tmp_path / "out"
    write(path)
    refused(said, "extract", path, "--robot", "panda", "--out", out)
    assert not out.exists()


def test_another_topic_may_be_asked_for_and_without_out_nothing_is_written(
    extract, refused, moves, tmp_path
):
    busy_bag(tmp_path / "session", "db3", moves)
    before = sorted(tmp_path.rglob("*"))
    words = (tmp_path / "session", "--robot", "panda", "--topic")
    refused("no sensor_msgs/JointState on /left; it has", "extract", *words, "/left")
    status, shown, _ = extract(*words, "/franka/joint_states")
    assert "read /franka/joint_states" in shown and status == 3  # five states a second: no rest
    assert "must stand still for two windows of 2.6 s" in shown
    status, shown, err = extract(*words, "/joint_states", "--json")
    rests = json.loads(shown)["rests"]
    assert status == 0 and "Nothing was written" in err
    assert [rest["socket"] for rest in rests] == moves.sockets
    assert all(rest["end"] > rest["begin"] > START - 1 for rest in rests)
    assert sorted(tmp_path.rglob("*")) == before


def question_of(path):
    return Question(path, NAMES, (False,) * 7)


def moving(seconds=4.0):
    """An arm that moves slowly: stamps, and positions."""
    stamps = np.arange(0, seconds, 0.05)
    return [(t, np.sin(0.1 * t + np.arange(7))) for t in stamps.tolist()]


def read(path, messages):
    with Bag(path, "mcap") as bag:
        for stamp, names, position in messages:
            bag.write("/joint_states", stamp, names, position)
    return read_log(Question(path, NAMES, (False,) * 7))


def called(prefix):
    return [f"{prefix}{name}" for name in NAMES]


@pytest.mark.parametrize("in_turn", [True, False])
def test_two_arms_that_tell_their_states_in_turn_are_two(tmp_path, in_turn):
    left = [(t, called("left_"), q) for t, q in moving()]
    right = [(t + (0.01 if in_turn else 9), called("right_"), q + 0.5) for t, q in moving()]
    with pytest.raises(mukca.MukcaError, match=r"may be any of left_panda.*--joints 'left_\*'"):
        read(tmp_path / "bag", sorted([*left, *right], key=lambda row: row[0]))


def test_one_arm_told_twice_is_read_by_the_names_of_the_model(tmp_path):
    own = [(t, NAMES, q) for t, q in moving()]
    again = [(t + 1e-3, called("fr3_0815_"), q + 1.0) for t, q in moving()]
    hand = [(t + 2e-3, ["finger"], [0.02]) for t, _ in moving()]
    log = read(tmp_path / "bag", sorted([*own, *again, *hand], key=lambda row: row[0]))
    assert np.array_equal(log.positions, [q for _, q in moving()])
    assert sum("are left out" in note for note in log.notes) == 2
    assert any("80 messages there are of fr3_0815_panda_joint1" in note for note in log.notes)


def test_a_clock_that_was_set_back_begins_another_part(tmp_path):
    with Bag(tmp_path / "bag", "mcap") as bag:
        for t, q in moving():
            back = 1.5 if t >= 2 else 0.0
            bag.write("/joint_states", t - back, NAMES, q, later=back)
    log = read_log(Question(tmp_path / "bag", NAMES, (False,) * 7))
    assert np.array_equal(log.positions, [q for _, q in moving()])
    assert log.parts.tolist() == [0] * 40 + [1] * 40
    assert any("the stamps went back by 1." in note for note in log.notes)


def test_two_publishers_of_the_same_joints_are_told_and_their_time_is_left_out(tmp_path):
    at_rest = np.random.default_rng(0).normal(np.full(7, 0.3), 1e-5, (200, 7))
    own = [(0.05 * k, NAMES, q) for k, q in enumerate(at_rest)]
    again = [(t + 0.02, NAMES, 0 * q) for t, _, q in own if 3 < t < 8]
    log = read(tmp_path / "bag", sorted([*own, *again], key=lambda row: row[0]))
    joints, stretches = [JointLimits(name) for name in NAMES], []
    rests = find_rests(log, joints, window=0.6, still=5e-4, unsound=stretches)
    (lost,) = [stretch for stretch in stretches if stretch.lasts]
    assert lost.why == "two sources send these joints in turn"
    begin, end = (moment - log.stamps[0] for moment in (lost.begin, lost.end))
    assert 3 < begin < 3.5 and 8 < end < 11.1
    assert len(rests) == 1 and rests[0].pose.position == pytest.approx([0.3] * 7, abs=1e-4)


def sagging(path, topics):
    """A bag of an arm whose topics say different things of it: their offsets, and states a step."""
    with Bag(path, "mcap") as bag:
        for t, q in moving():
            for topic, (offset, count) in topics.items():
                for k in range(count):
                    bag.write(topic, t + 1e-3 * k, NAMES, q + offset)
    return read_log(Question(path, NAMES, (False,) * 7))


MEASURED = [q for _, q in moving()]


@pytest.mark.parametrize(
    "measured, commanded",
    [
        ("/joint_states", "/joint_command"),
        ("/arm/joint_states", "/arm/desired_joint_states"),
        ("/joints", "/joint_states/goal"),
        ("/measured_jp", "/joint_states"),
        ("/slave/measured_js", "/slave/setpoint_js"),
    ],
)
def test_what_was_measured_is_read_however_many_commands_there_are(tmp_path, measured, commanded):
    log = sagging(tmp_path / "bag", {commanded: (0.02, 3), measured: (0.0, 1)})
    assert np.array_equal(log.positions, MEASURED)
    assert f"read {measured}, 80 states" in log.notes[0] and commanded in log.notes[1]


def test_what_never_moved_is_no_measurement(tmp_path):
    with Bag(tmp_path / "bag", "mcap") as bag:
        for t, q in moving():
            bag.write("/joint_states", t, NAMES, 0 * q)
            bag.write("/joint_states", t + 1e-3, NAMES, 0 * q)
            bag.write("/driver/joint_states", t, NAMES, q)
    log = read_log(Question(tmp_path / "bag", NAMES, (False,) * 7))
    assert np.array_equal(log.positions, MEASURED)


def test_a_choice_that_is_not_plain_is_asked_for(tmp_path):
    with pytest.raises(mukca.MukcaError, match=r"/a and /b have .* 0.02 rad apart: .*--topic"):
        sagging(tmp_path / "bag", {"/a": (0.02, 1), "/b": (0.0, 1)})
    assert len(sagging(tmp_path / "same", {"/a": (0.0, 1), "/b": (0.0, 1)}).stamps) == 80


def test_commands_alone_are_said_to_be_commands(tmp_path):
    log = sagging(tmp_path / "bag", {"/joint_command": (0.0, 1)})
    assert "/joint_command is called like commands" in log.notes[1]


def test_degrees_in_a_bag_are_told_and_read(tmp_path):
    def written(**units):
        return read_log(Question(tmp_path / "bag", NAMES, (False,) * 7, **units))

    with pytest.raises(mukca.MukcaError, match=r"an angle of .* rad; .* say --units degrees"):
        read(tmp_path / "bag", [(t, NAMES, np.degrees(q)) for t, q in moving()])
    assert np.allclose(written(units="degrees").positions, MEASURED)
    with pytest.raises(mukca.MukcaError, match="for a bag, radians or degrees"):
        written(units="arm.json")


def test_stamps_of_whole_seconds_give_way_to_the_bags_times(tmp_path):
    with Bag(tmp_path / "bag", "mcap") as bag:
        for t, q in moving():
            bag.write("/joint_states", np.floor(t), NAMES, q, later=t - np.floor(t))
    log = read_log(Question(tmp_path / "bag", NAMES, (False,) * 7))
    assert np.allclose(np.diff(log.stamps), 0.05, atol=1e-6)
    assert any("stamps are whole seconds" in note for note in log.notes)


def test_single_poses_are_no_log(tmp_path):
    with pytest.raises(
        mukca.MukcaError, match=r"typically 4 s apart; .* of single poses make a ta"
    ):
        read(tmp_path / "bag", [(80 * t, NAMES, q) for t, q in moving()])


def test_poses_alone_are_no_joint_states(refused, tmp_path):
    with Bag(tmp_path / "bag", "mcap") as bag:
        bag.topic("/tcp_pose", "geometry_msgs/msg/PoseStamped")
    said = "PoseStamped): poses do not tell how the joints stood; record joint states"
    refused(said, "extract", tmp_path / "bag", "--robot", "panda")


@pytest.mark.parametrize("name", ["a.mcap", "a.csv", "data/a.parquet"])
def test_a_file_that_git_did_not_bring_is_named(refused, tmp_path, name):
    file = tmp_path / "set" / name
    file.parent.mkdir(parents=True)
    file.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n")
    info = {"codebase_version": "v3.0", "features": {"observation.state": {"names": NAMES}}}
    (tmp_path / "set" / "meta").mkdir()
    (tmp_path / "set" / "meta" / "info.json").write_text(json.dumps(info))
    path = tmp_path / "set" if name.startswith("data") else file
    words = ["--units", "degrees"] * name.startswith("data")
    refused("is a Git LFS pointer, not the data", "extract", path, "--robot", "panda", *words)
