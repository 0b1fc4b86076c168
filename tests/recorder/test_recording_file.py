"""What is captured is on the disk, reads back exactly, and survives whatever happens to it."""

import os
from dataclasses import replace
from pathlib import Path

import pytest
from full_disk import full_disk
from hypothesis import given, settings
from hypothesis import strategies as st

from mukca import MukcaError, Placement
from mukca.recorder import Metadata, Sample, hole_files, read_placement, read_samples, sample_files
from mukca.recorder.session import Recording
from mukca.solver.results import write_files

METADATA = Metadata("arm", ("a", "b,c"), ("rad", "m"), 0.05, model_sha256="1f")
exact = st.floats(-1e20, 1e20)
pairs = st.tuples(exact, exact)


def sample(number, socket=0):
    return Sample(
        (0.1 * number, -0.2), socket, (1.5, 2.5), "", number, 1.7e9 + number, 0.5, 300, (1e-5, 2e-5)
    )


def bare(samples):
    return [replace(s, where="") for s in samples]


def record(folder, *numbers):
    with Recording(folder, METADATA) as recording:
        for number in numbers:
            recording.capture(sample(number))


@pytest.mark.parametrize("numbers", [(), (1,)])
def test_an_error_before_the_first_sample_leaves_nothing_behind(tmp_path, numbers):
    folder, there = tmp_path / "data/front", tmp_path / "there"
    there.mkdir()
    for place in (folder, there):
        with pytest.raises(MukcaError), Recording(place, METADATA) as recording:
            for number in numbers:
                recording.capture(sample(number))
            raise MukcaError
        assert (place / "samples.csv").exists() == bool(numbers)
        assert (place / "placement.json").exists() == bool(numbers)
    assert folder.parent.exists() == bool(numbers) and there.exists()
    with Recording(there, METADATA), pytest.raises(MukcaError):
        Recording(there, METADATA)  # it is open
    assert (there / "samples.csv").exists()
    with pytest.raises(MukcaError), Recording(there, METADATA):
        raise MukcaError
    assert (there / "samples.csv").exists()


def test_a_description_that_was_there_outlives_an_error(tmp_path):
    (tmp_path / "placement.json").write_text('{"place": "table"}')
    with pytest.raises(MukcaError), Recording(tmp_path, METADATA):
        raise MukcaError
    assert '"table"' in (tmp_path / "placement.json").read_text()


@pytest.mark.slow
@settings(max_examples=30)
@given(rows=st.lists(st.tuples(pairs, st.none() | pairs, st.none() | pairs, exact), max_size=5))
def test_what_is_written_reads_back_exactly(rows, tmp_path_factory):
    folder = tmp_path_factory.mktemp("exact")
    written = [
        Sample(position, k % 3, effort, "", k, time, time, k + 1, spread)
        for k, (position, effort, spread, time) in enumerate(rows, start=1)
    ]
    with Recording(folder, METADATA) as recording:
        for one in written:
            recording.capture(one)
    content = read_samples(folder / "samples.csv")
    assert bare(content.samples) == written
    assert content.joint_names == METADATA.joints


@pytest.fixture
def synced(monkeypatch):
    """Files and folders as they are synced, with the size of a file by then."""
    synced = []
    true_sync = os.fsync

    def sync(descriptor):
        true_sync(descriptor)
        path = Path(f"/proc/self/fd/{descriptor}").readlink()
        synced.append((path, os.fstat(descriptor).st_size if path.is_file() else 0))

    monkeypatch.setattr(os, "fsync", sync)
    return synced


def test_a_capture_is_synced_before_it_returns(tmp_path, synced):
    file = tmp_path / "samples.csv"
    with Recording(tmp_path, METADATA) as recording:
        before = len(synced)
        for number in (1, 2):
            recording.capture(sample(number))
            assert synced[-1] == (file, file.stat().st_size)
        assert len(synced) == before + 2


def test_new_files_are_synced_before_their_folder_and_that_before_they_are_used(tmp_path, synced):
    folder = tmp_path / "data/front"
    Recording(folder, METADATA).close()
    assert {(tmp_path, 0), (tmp_path / "data", 0)} <= set(synced)
    header = (folder / "samples.csv", (folder / "samples.csv").stat().st_size)
    assert header[1] > 0 and header in synced[: synced.index((folder, 0))]
    written = (folder / "placement.json").stat().st_size
    before_last = synced[: len(synced) - 1 - synced[::-1].index((folder, 0))]
    beside = [(file, size) for file, size in before_last if file.name.startswith(".placement.json")]
    assert beside[-1][1] == written  # under another name until it was whole


def test_files_that_belong_together_are_whole_before_the_first_is_renamed(tmp_path, synced):
    out = tmp_path / "data/out"
    write_files(out, {"a.json": b"12", "left/b.urdf": b"123"})
    beside = [(file.parent, file.name[:3], size) for file, size in synced if file.name[0] == "."]
    assert beside == [(out, ".a.", 2), (out / "left", ".b.", 3)]
    assert {file for file, _ in synced[-2:]} == {out, out / "left"}


def test_a_full_disk_leaves_the_file_as_it_was_and_nothing_beside_it(tmp_path):
    with Recording(tmp_path, METADATA) as recording:
        before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
        with full_disk(10), pytest.raises(MukcaError, match=r"placement\.json cannot be written"):
            recording.set_socket(1)
        with full_disk(10), pytest.raises(MukcaError, match=r"samples\.csv cannot be written"):
            recording.capture(sample(1))
        assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before
    with full_disk(0), pytest.raises(MukcaError, match="front: cannot be written"):
        Recording(tmp_path / "data/front", METADATA)
    assert not (tmp_path / "data").exists()


def test_joints_are_checked_even_without_metadata(tmp_path):
    record(tmp_path, 1)
    (tmp_path / "placement.json").unlink()
    with pytest.raises(MukcaError, match=r"samples\.csv:1: recorded with joints"):
        Recording(tmp_path, replace(METADATA, joints=("a", "c")))


def test_an_alarm_that_was_kept_stands_in_the_recording(tmp_path):
    record(tmp_path, 1)
    for text in ("the base moved", "the ball sat elsewhere"):
        with Recording(tmp_path, METADATA) as recording:
            recording.keep_alarm(text)
            recording.set_socket(1)
    alarms = read_placement(tmp_path).kept_alarms
    assert alarms == ("the base moved", "the ball sat elsewhere")


def test_a_changed_model_is_told(tmp_path):
    record(tmp_path, 1)
    with Recording(tmp_path, replace(METADATA, model_sha256="2e")) as recording:
        assert any("model has changed" in remark for remark in recording.remarks)


@pytest.mark.slow
def test_a_torn_end_costs_only_itself(tmp_path):
    """Cut the file anywhere: all whole lines stay, the rest is kept aside, and it goes on."""
    record(tmp_path / "whole", 1)
    whole = (tmp_path / "whole/samples.csv").read_bytes()
    lines = whole.splitlines(keepends=True)
    end = len(lines[0])
    for length in (*range(0, end, 7), end - 1, end, end + 1, *range(end + 2, len(whole), 3)):
        folder = tmp_path / f"cut_{length}"
        folder.mkdir()
        (folder / "samples.csv").write_bytes(whole[:length])
        left = whole[:length].splitlines(keepends=True)
        torn = left.pop() if left and not left[-1].endswith(b"\n") else b""
        with Recording(folder, METADATA) as recording:
            assert len(recording.content.samples) == max(0, len(left) - 1)
            assert bool(torn) == any("torn off" in remark for remark in recording.remarks)
            recording.capture(sample(max(1, len(left))))
        aside = [file.read_bytes() for file in folder.glob("samples.csv.torn-*")]
        assert aside == ([torn] if torn else [])
        kept = (folder / "samples.csv").read_bytes().splitlines(keepends=True)
        assert kept[:-1] == (left or lines[:1])


@pytest.mark.parametrize("how", ["appended", "replaced", "deleted"])
def test_a_file_that_was_changed_meanwhile_is_not_written_to(tmp_path, how):
    file = tmp_path / "samples.csv"
    with Recording(tmp_path, METADATA) as recording:
        recording.capture(sample(1))
        if how == "appended":
            with file.open("a") as stream:
                stream.write("a note")
        else:
            content = file.read_bytes()
            file.unlink()
            if how == "replaced":
                file.write_bytes(content)
        with pytest.raises(MukcaError, match=r"changed by another|moved, renamed"):
            recording.capture(sample(2))


@pytest.mark.parametrize("place", ["file", "beneath a file", "read-only", "holes"])
def test_a_folder_that_cannot_be_used_is_told(tmp_path, place):
    folder = tmp_path / "front"
    if place == "holes":
        folder.mkdir()
        (folder / "hole_0.csv").write_text("1,2\n")
    elif place == "read-only":
        folder = Path("/proc/front")
    else:
        folder.write_text("")
        folder = folder / "below" if place == "beneath a file" else folder
    with pytest.raises(MukcaError, match="front"):
        Recording(folder, METADATA)


@settings(max_examples=30)
@given(rows=st.lists(pairs, min_size=1, max_size=4))
def test_either_form_converts_to_the_other_and_back(rows, tmp_path_factory):
    folder = tmp_path_factory.mktemp("forms")
    samples = tuple(Sample(row, k // 2) for k, row in enumerate(rows))
    read = Placement("x", samples, None, 0.05)
    for form in (hole_files, sample_files, hole_files):
        for file in folder.iterdir():
            file.unlink()
        for name, content in form(read).items():
            (folder / name).write_bytes(content)
        read = read_placement(folder)
        assert [(s.position, s.socket) for s in read.samples] == [
            (s.position, s.socket) for s in samples
        ]
        assert read.distance == 0.05
