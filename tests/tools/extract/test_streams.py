"""Streams that the recorder keeps, read back."""

import base64

import numpy as np
import pytest
from full_disk import full_disk

from mukca.drivers import JointState
from mukca.recorder import StreamLog, next_log_file, read_stream_log


def test_a_kept_stream_reads_back(tmp_path):
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


def test_a_stream_of_the_older_format_is_read(tmp_path):
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


def keep(file, states, first=0):
    """Keep so many states, some 4 kB in each block of 1000."""
    kept = StreamLog(file, ["a"])
    rng = np.random.default_rng(3)
    for i in range(first, first + states):
        kept.add(JointState(1e-3 * i, (float(rng.normal()),)), 0)
    kept.close()
    return kept


def thousands(file):
    """Return which blocks of 1000 states a file still gives, each of them whole."""
    read = read_stream_log(file)
    first = np.rint(1e3 * read.stamps[::1000]).astype(int)
    expected = [np.arange(start, start + 1000) for start in first]
    assert np.rint(1e3 * read.stamps).astype(int).tolist() == np.ravel(expected).tolist()
    return (first // 1000).tolist(), read.remarks


@pytest.mark.parametrize("room", [4, 3000])
def test_a_full_disk_tears_no_block(tmp_path, room):
    file = tmp_path / "a.stream"
    keep(file, 2000)
    whole = file.stat().st_size
    file.unlink()
    with full_disk(whole + room):
        kept = keep(file, 5000)
    assert kept.trouble == "a.stream: no more states are kept: File too large"
    assert file.stat().st_size == whole
    assert thousands(file) == ([0, 1], ())


@pytest.mark.slow
def test_a_block_that_is_damaged_costs_itself_alone(tmp_path):
    """Wherever it is, and whether bytes changed, are missing, or too many."""
    file = tmp_path / "a.stream"
    keep(file, 5000)
    data = file.read_bytes()
    blocks = len(data) - data.index(b"\n") - 1
    rng = np.random.default_rng(5)
    for start in rng.integers(len(data) - blocks, len(data) - 40, 60).tolist():
        for change in (b"\xff" * 40, b"", rng.bytes(200)):
            file.write_bytes(data[:start] + change + data[start + 40 :])
            found, remarks = thousands(file)
            assert 3 <= len(found) < 5 and len(remarks) == 1
            gap = next(n for n in range(5) if n not in found)
            before = f"{gap - 0.001:.3f} s" if gap else "the beginning"
            assert f"between {before} and " in remarks[0] and "left out" in remarks[0]


def test_what_a_crash_tore_off_is_not_read(tmp_path):
    file = tmp_path / "a.stream"
    keep(file, 3000)
    data = file.read_bytes()
    for missing in (1, 3, 1000):
        file.write_bytes(data[:-missing])
        found, remarks = thousands(file)
        assert found == [0, 1]
        assert remarks == (
            f"{file}: the states between 1.999 s and the end are damaged, and left out",
        )


def test_a_day_of_1_khz_fits_on_a_laptop(tmp_path):
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
