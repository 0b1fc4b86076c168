"""One base after the other: folders in series, and samples that move on and are never lost."""

import json
from pathlib import Path

import pytest
from full_disk import full_disk

from mukca.recorder import Metadata, Sample, newest_folder, next_folder, read_samples
from mukca.recorder.session import GuidanceClient, Recording, Session, SessionActions, Sound
from mukca.recorder.stream import JointLimits
from mukca.recorder.terminal.key_handler import KeyHandler

NAMES = tuple(f"joint_{i}" for i in range(20))
METADATA = Metadata("arm", NAMES, ("rad",) * 20, 0.05, measured=True)
JOINTS = tuple(JointLimits(name, -1, 1) for name in NAMES)


def make(folder, second):
    folder.mkdir()
    (folder / "samples.csv").touch()
    sessions = [{"started": f"2026-11-28T19:00:{second:02}+00:00"}]
    (folder / "placement.json").write_text(json.dumps({"sessions": sessions}))


@pytest.mark.parametrize(
    ("folders", "folder", "newest", "after"),
    [
        ([], "front", "front", "front-2"),
        (["front"], "front", "front", "front-2"),
        (["front", "front-2"], "front", "front-2", "front-3"),
        (["front", "front-2"], "front-2", "front-2", "front-3"),
        (["front", "front-2", "front-10"], "front-2", "front-10", "front-11"),
        (["front-3", "front-2", "front"], "front-2", "front", "front-4"),
        (["front", "front-20261128", "front-b"], "front", "front", "front-2"),
        (["ur-5"], "ur-5", "ur-5", "ur-5-2"),
        (["front-2"], "front", "front", "front-3"),
    ],
)
def test_the_newest_of_a_series_goes_on_and_the_next_is_after_all(
    tmp_path, folders, folder, newest, after
):
    for second, name in enumerate(folders):
        make(tmp_path / name, second)
    assert newest_folder(tmp_path / folder) == tmp_path / newest
    assert next_folder(tmp_path / folder) == tmp_path / after


def test_the_current_folder_has_a_next_one(tmp_path, monkeypatch):
    make(tmp_path / "front", 0)
    monkeypatch.chdir(tmp_path / "front")
    assert newest_folder(Path()) == Path()
    assert next_folder(Path()) == tmp_path / "front-2"


class Watched(Recording):
    """A recording that sees what stands in the next folder when it takes samples back."""

    def mark(self, *arguments):
        beside = self.folder.with_name("front-2") / "samples.csv"
        self.seen = [*getattr(self, "seen", []), beside.exists() and read_samples(beside).samples]
        super().mark(*arguments)


@pytest.fixture
def actions(tmp_path):
    with Watched(tmp_path / "front", METADATA) as recording:
        actions = SessionActions(Session(JOINTS), recording, Sound(lambda: None))
        for number in range(1, 9):
            sample = Sample((0.1 * number,) * 20, number % 2, number=number, states=9)
            recording.capture(sample)
            actions.session = actions.session.captured(sample)
        yield actions


def test_samples_are_on_the_disk_in_the_next_folder_before_they_leave_this_one(tmp_path, actions):
    assert actions.begin_next((5, 6), readings_changed=True)
    successor = actions.successor
    expected = [sample.position for sample in actions.session.samples[4:]]
    (seen,) = actions.recording.seen
    assert [sample.position for sample in seen] == expected
    assert [sample.number for sample in successor.content.live] == [1, 2, 3, 4]
    assert (successor.folder, successor.socket) == (tmp_path / "front-2", 0)
    assert json.loads((tmp_path / "front-2/placement.json").read_text())["readings_changed"]
    successor.close()
    assert [s.number for s in read_samples(tmp_path / "front/samples.csv").live] == [1, 2, 3, 4]


@pytest.mark.parametrize("room", ["nothing", "no sample", "no mark in this placement"])
def test_a_full_disk_refuses_a_next_placement_and_loses_nothing(tmp_path, actions, room):
    file = tmp_path / "front/samples.csv"
    before = file.read_bytes()
    header = before.index(b"\n") + 100
    with full_disk({"nothing": 10, "no sample": header}.get(room, len(before))):
        assert not actions.begin_next((5, 6))
    assert actions.successor is None and actions.session.messages[-1].text.startswith("not done: ")
    assert file.read_bytes() == before and len(actions.session.live) == 8
    assert not (tmp_path / "front-2").exists()
    assert actions.begin_next((5, 6))
    actions.successor.close()


def test_a_refused_new_placement_leaves_no_question_open(actions):
    """Else the keys after it would be taken for answers, and do nothing."""
    guidance = GuidanceClient(None, actions, actions.sound)
    handler = KeyHandler(actions, guidance, lambda: None)
    with full_disk(10):
        handler.press("n")
        handler.press("y")
    assert not actions.session.finished and actions.successor is None
    handler.press("u")
    assert actions.session.withdrawn == (8,)
