"""CSV logs, lerobot data sets, and streams that the recorder kept."""

import json
import re

import numpy as np
import pytest
from cases import by_table

import mukca
from mukca.tools.cli import main
from mukca.tools.extract import Question, read_log

pytestmark = pytest.mark.slow

NAMES = tuple(f"panda_joint{i}" for i in range(1, 8))


def finite(moves):
    return [state for state in moves.states if np.isfinite(state.position).all()]


# -- CSV -------------------------------------------------------------------------------------------


def foreign(file, moves):
    """A log as a German spreadsheet has it: BOM, semicolons, decimal commas, a row of units."""
    order = [2, 0, 1, 3, 6, 5, 4]
    lines = [";".join(["gripper", "Timestamp", *(f"left/{NAMES[k]}" for k in order)])]
    lines.append(";".join(["mm", "ms", *["[deg]"] * 7]))
    for state in finite(moves):
        angles = [np.degrees(state.position[k]) for k in order]
        cells = [f"{value:.9f}" for value in (40.0, 1e3 * state.stamp, *angles)]
        lines.append(";".join(cells).replace(".", ","))
    file.write_text("\ufeff" + "\n".join(lines) + "\n", encoding="utf-8")


def test_a_foreign_csv_log(extract, moves, tmp_path):
    foreign(tmp_path / "log.csv", moves)
    words = ("--robot", "panda", "--out", tmp_path / "out")
    status, _, err = extract(tmp_path / "log.csv", *words)
    assert status == 0, err
    moves.read_back(tmp_path / "out" / "placement_1")


def plain(file, moves, head="t", scale=1.0, step=1.0):
    lines = [",".join([head, *NAMES])]
    for state in finite(moves)[:100]:
        numbers = (step * state.stamp, *(scale * value for value in state.position))
        lines.append(",".join(map(repr, numbers)))
    file.write_text("\n".join(lines) + "\n")
    return file


@by_table("given", "words", "said")
def test_a_csv_log_that_cannot_be_used(refused, moves, tmp_path, given, words, said):
    file = plain(tmp_path / "log.csv", moves, **given)
    refused(said, "extract", file, "--robot", "panda", *words, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("heads", "parts"),
    [
        ("sec,nanosec", 1e9),
        ("header.stamp.secs,header.stamp.nsecs", 1e9),
        ("time_s,time_us", 1e6),
        ("timestamp,milliseconds", 1e3),
        ("ticks,time_ms", None),
    ],
)
def test_stamps_in_two_columns_or_in_a_unit_by_name_are_read(moves, tmp_path, heads, parts):
    lines = [",".join([heads, *NAMES])]
    states = finite(moves)[:100]
    for state in states:
        whole = int(state.stamp // 1)
        cells = (whole, round((state.stamp - whole) * (parts or 0)))
        if not parts:
            cells = (7, 1e3 * state.stamp)
        lines.append(",".join(map(repr, (*cells, *state.position))))
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    log = read_log(Question(tmp_path / "log.csv", NAMES, (False,) * 7))
    assert log.stamps == pytest.approx([state.stamp for state in states], abs=1e-6)


def test_stamps_of_whole_seconds_are_told(refused, moves, tmp_path):
    file = plain(tmp_path / "log.csv", moves, head="time")
    head, *lines = file.read_text().splitlines()
    whole = [f"{re.sub(r'[.][0-9]+', '', line, count=1)},3" for line in lines]
    file.write_text("\n".join([f"{head},latency_ms", *whole]))
    refused("many rows have one time: write its fractions", "extract", file, "--robot", "panda")


# -- lerobot ---------------------------------------------------------------------------------------


def data_set(folder, moves, version, values, names):
    """A data set of two episodes, one for each socket, as lerobot lays it out."""
    pyarrow = pytest.importorskip("pyarrow", reason="the extra lerobot is not installed")
    parquet = pytest.importorskip("pyarrow.parquet")

    states = finite(moves)
    fps = 40
    stamps = np.array([state.stamp for state in states])
    # from one episode to the next while the arm moved
    episodes = (
        stamps - stamps[0] > 13 * (moves.hold + moves.move) + moves.hold + moves.move / 2
    ).astype(int)
    info = {
        "codebase_version": version,
        "robot_type": "panda",
        "fps": fps,
        "features": {
            "observation.state": {
                "dtype": "float32",
                "shape": [values.shape[1]],
                "names": names if version == "v3.0" else {"motors": names},
            }
        },
    }
    (folder / "meta").mkdir(parents=True)
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    for episode in (0, 1):
        mine = np.flatnonzero(episodes == episode)
        table = pyarrow.table(
            {
                "observation.state": pyarrow.array(
                    values[mine].tolist(), pyarrow.list_(pyarrow.float32())
                ),
                "timestamp": pyarrow.array(stamps[mine] - stamps[mine[0]], pyarrow.float32()),
                "episode_index": pyarrow.array(episodes[mine]),
            }
        )
        chunk = folder / "data" / "chunk-000"
        chunk.mkdir(parents=True, exist_ok=True)
        parquet.write_table(table, chunk / f"episode_{episode:06}.parquet")


def test_more_numbers_than_an_arm_writes_are_refused_before_they_are_read(refused, moves, tmp_path):
    """Of equal numbers, kilobytes hold millions."""
    data_set(tmp_path / "set", moves, "v3.0", np.zeros((len(finite(moves)), 7)), list(NAMES))
    pyarrow = pytest.importorskip("pyarrow")
    rows = 20_000_000
    zeros = pyarrow.array(np.zeros(rows, np.int8))
    table = pyarrow.table(dict.fromkeys(("timestamp", "episode_index", "more"), zeros))
    file = tmp_path / "set" / "data" / "chunk-000" / "episode_000000.parquet"
    pyarrow.parquet.write_table(table, file)
    assert file.stat().st_size < 1_000_000
    words = ("extract", tmp_path / "set", "--robot", "panda", "--units", "degrees")
    refused("episode_000000.parquet: 60000000 numbers; at most 50000000 are read", *words)


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_lerobot_in_degrees(extract, refused, moves, tmp_path, version):
    angles = np.degrees([state.position for state in finite(moves)])
    values = np.hstack([angles, np.full((len(angles), 1), 50.0)])
    suffix = ".pos" if version == "v3.0" else ""
    names = [f"{name}{suffix}" for name in (*NAMES, "gripper")]
    data_set(tmp_path / "set", moves, version, values, names)
    words = ("--robot", "panda", "--out", tmp_path / "out")
    refused("does not say its units", "extract", tmp_path / "set", *words)
    assert not (tmp_path / "out").exists()
    refused("say --units degrees", "extract", tmp_path / "set", *words, "--units", "radians")
    assert not (tmp_path / "out").exists()
    info = tmp_path / "set" / "meta" / "info.json"
    info.write_text(info.read_text().replace('"fps": 40', '"fps": "40 Hz"'))  # not needed
    status, shown, _ = extract(tmp_path / "set", *words, "--units", "degrees")
    assert status == 0 and "2 episodes" in shown and "episode" in shown.split()
    moves.read_back(tmp_path / "out" / "placement_1")


def test_lerobot_normalised_by_the_arms_calibration(extract, moves, tmp_path):
    # as drivers/arms/servos/joint_maps.py has it, in true ticks
    same = {"homing_offset": 7, "range_min": 10}
    motors = {
        name: {**same, "id": i, "drive_mode": i % 2, "range_max": 4000 + i}
        for i, name in enumerate(NAMES)
    }
    (tmp_path / "arm.json").write_text(json.dumps(motors))
    ticks = np.array([state.position for state in finite(moves)]) * 4096 / (2 * np.pi)
    spans = np.array([motor["range_max"] - motor["range_min"] for motor in motors.values()])
    signs = np.array([-1 if motor["drive_mode"] else 1 for motor in motors.values()])
    values = np.clip(signs * ticks / spans * 200, -100, 100)
    clipped = np.any(np.abs(values) == 100, axis=1)
    data_set(tmp_path / "set", moves, "v3.0", values, list(NAMES))
    words = ("--units", tmp_path / "arm.json", "--out", tmp_path / "out")
    status, shown, err = extract(tmp_path / "set", "--robot", "panda", *words)
    assert status == 0, err
    assert ("are left out" in shown) == bool(clipped.any())
    reached = mukca.read_placements(tmp_path / "out" / "placement_1")[0].positions
    near = np.abs(reached[:, None] - np.array(moves.places)[None]).max(axis=2).min(axis=1)
    assert near.max() < 4e-5 and len(reached) >= 20
    status, _, err = extract(
        tmp_path / "set", "--robot", "panda", "--units", tmp_path / "set" / "meta" / "info.json"
    )
    assert status == 2 and "info.json" in err


@pytest.mark.parametrize("kind", ["set", "log.csv"])
def test_parts_of_a_range_are_no_degrees(refused, moves, tmp_path, kind):
    """Values that end at 100 exactly: nobody can make radians of them without the ranges."""
    angles = np.array([state.position for state in finite(moves)][:100])
    values = np.clip(100 * angles / np.abs(angles).max(), -100, 100)
    data_set(tmp_path / "set", moves, "v3.0", np.resize(values, (len(finite(moves)), 7)), [*NAMES])
    rows = [",".join(map(str, (i / 40, *row))) for i, row in enumerate(values)]
    (tmp_path / "log.csv").write_text("\n".join([",".join(["t", *NAMES]), *rows]))
    words = ("--robot", "panda", "--units", "degrees")
    refused("values end at 100 exactly: no degrees", "extract", tmp_path / kind, *words)


def test_servos_with_coarse_encoders(extract, moves, tmp_path):
    """Positions in ticks of 1.5 mrad, which trembling joints step over: still at rest."""
    rng = np.random.default_rng(1)
    true = np.array([state.position for state in finite(moves)])
    ticks = np.round(true * 4096 / (2 * np.pi) + rng.normal(0, 0.35, true.shape))
    data_set(tmp_path / "set", moves, "v2.1", ticks * 360 / 4095, list(NAMES))
    info = tmp_path / "set" / "meta" / "info.json"
    info.write_text(info.read_text().replace('"panda"', '"so101_follower"'))
    words = ("--units", "degrees", "--out", tmp_path / "out")
    status, _, err = extract(tmp_path / "set", "--robot", "panda", *words)
    assert status == 0, err
    moves.read_back(tmp_path / "out" / "placement_1", within=2e-3)


def test_a_damaged_data_set(refused, moves, tmp_path):
    values = np.degrees([state.position for state in finite(moves)])
    data_set(tmp_path / "set", moves, "v2.1", values, list(NAMES))
    words = (tmp_path / "set", "--robot", "panda", "--units", "degrees")
    file = tmp_path / "set" / "data" / "chunk-000" / "episode_000001.parquet"
    file.write_bytes(file.read_bytes()[:-200])
    refused("episode_000001.parquet", "extract", *words)
    info = tmp_path / "set" / "meta" / "info.json"
    info.write_text(info.read_text().replace("v2.1", "v9.0"))
    refused("version v9.0", "extract", *words)
    info.write_text("{}}")
    refused("cannot be read", "extract", *words)


# -- kept streams ----------------------------------------------------------------------------------


def test_what_was_captured_can_be_looked_at_again(
    extract, refused, session, tmp_path, virtual_time
):
    keys, out = tmp_path / "keys", tmp_path / "front"
    keys.write_text("a*12 s a*12 q")
    driver = f"mock:{session / 'front'}?rate=100&hold=1&move=0.8"
    words = ["record", "--robot", "panda", "--driver", driver, "--out", str(out)]
    assert main([*words, "--keys", str(keys), "--keep-stream"]) == 0
    assert {file.name for file in out.iterdir()} >= {"samples.csv", "states_1.stream"}
    status, _, err = extract(out, "--robot", "panda", "--out", tmp_path / "again")
    assert status == 0, err
    captured, found = mukca.read_placements(out)[0], mukca.read_placements(tmp_path / "again")[0]
    assert found.sockets.tolist() == captured.sockets.tolist()
    # each the mean of some 30 states with 2e-5 rad of noise
    assert np.abs(found.positions - captured.positions).max() < 5 * 2e-5 / np.sqrt(15)
    refused("it has panda_joint1", "extract", out / "states_1.stream", "--robot", "ur5e")
    (out / "states_1.stream").write_bytes(b"something else\n")
    refused("not a stream of states", "extract", out, "--robot", "panda")
