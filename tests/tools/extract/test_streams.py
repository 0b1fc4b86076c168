"""Streams that the recorder keeps, read back."""

import base64

import numpy as np

from mukca.drivers import JointState
from mukca.recorder import StreamLog, next_log_file, read_stream_log


def test_a_kept_stream_reads_back(tmp_path) -> None:
    rng = np.random.default_rng(0)
    states = [
        JointState(
            1.7e9 + 1e-3 * i,
            tuple(rng.uniform(-3, 3, 3).tolist()),
            tuple(rng.uniform(-80, 80, 3).tolist()),
        )
        for i in range(2500)
    ]
    file = next_log_file(tmp_path)
    kept = StreamLog(file, ["a", "b", "c"])
    for i, state in enumerate(states):
        kept.add(state, i // 1000)
        kept.add(JointState(state.stamp, (float("nan"),) * 3), 0)
        kept.add(JointState(state.stamp, (0.1,)), 0)
    kept.close()
    kept.close()
    read = read_stream_log(file)
    assert read.joints == ("a", "b", "c") and read.efforts is not None
    assert np.abs(read.stamps - [state.stamp for state in states]).max() <= 1e-6
    assert np.abs(read.positions - [state.position for state in states]).max() < 0.51e-7
    assert np.abs(read.efforts - [state.effort for state in states]).max() < 0.51e-3
    assert read.connections.tolist() == [i // 1000 for i in range(2500)]
    assert next_log_file(tmp_path).name == "states_2.stream"


def test_a_stream_of_the_older_format_is_read(tmp_path) -> None:
    """Its head said nothing of its digits: 1e-9 rad, 1e-4 N m."""
    packed = (
        "VgAAAHicY2ZgYHC4cAFIMjEwaDEw/GdgKGJg2M/AcIidnQEMZh069JGBIYGBQZ2BwZsBCra/fs0KZnAy"
        "MBjABPm4ubVgbA8GBGCEMUQYsAAebIJYAQCloAxz"
    )
    file = tmp_path / "states_1.stream"
    head = b'{"format": "mukca-stream-1", "joints": ["a", "b"]}\n'
    file.write_bytes(head + base64.b64decode(packed))
    read = read_stream_log(file)
    assert read.efforts is not None
    assert np.abs(read.stamps - 1700000000.5 - [0, 0.001, 0.002]).max() < 1e-6
    assert np.abs(read.positions - [[0.123456789 + 0.1 * i, -2.5] for i in range(3)]).max() < 1e-12
    assert np.abs(read.efforts - [1.2345, -30.0]).max() < 1e-12


def test_what_a_crash_tore_off_is_not_read(tmp_path) -> None:
    kept = StreamLog(tmp_path / "a.stream", ["a"])
    for i in range(2500):
        kept.add(JointState(1e-3 * i, (0.1,)), 0)
    kept.close()
    data = (tmp_path / "a.stream").read_bytes()
    (tmp_path / "a.stream").write_bytes(data[:-3])
    assert len(read_stream_log(tmp_path / "a.stream").stamps) == 2000


def test_a_day_of_1_khz_fits_on_a_laptop(tmp_path) -> None:
    rng = np.random.default_rng(0)
    kept = StreamLog(tmp_path / "a.stream", list("abcdefg"))
    position, effort = np.zeros(7), np.zeros(7)
    for i in range(5000):
        read = position + rng.normal(0, 2e-5, 7)  # a moving arm's noise, as its encoders have it
        torque = effort + rng.normal(0, 0.02, 7)
        kept.add(JointState(1e-3 * i, tuple(read.tolist()), tuple(torque.tolist())), 0)
        position = position + 1e-3 * np.sin(1e-3 * i + np.arange(7))
    kept.close()
    a_day = (tmp_path / "a.stream").stat().st_size / 5 * 86_400
    assert a_day < 2e9
