"""Recordings that are continued, and what is not."""

import json
import re

import pytest
from cases import by_table
from record_commands import PANDA_HOME, capture, command, read
from recorded import readings_in
from terminal_session import TerminalSession

from mukca.tools.cli import main


@pytest.mark.slow
def test_the_same_out_continues(tmp_path, scripted):
    out = tmp_path / "front"
    assert scripted(out, "a*2 s a q").status == 0
    again = scripted(out, "u a*2 q")
    assert again.status == 0
    assert "continues a recording of 3 samples" in again.output
    assert read(out).sockets.tolist() == [0, 0, 1, 1]


@by_table("change", "told")
def test_another_robot_or_base_does_not_continue(tmp_path, scripted, change, told):
    out = tmp_path / "front"
    assert scripted(out, "a q", "--distance", "0.05").status == 0
    before = (out / "samples.csv").read_bytes()
    done = scripted(out, "a q", *change)
    assert done.status == 2
    assert told in done.errors and done.errors.count("\n") == 1
    assert (out / "samples.csv").read_bytes() == before


def test_a_distance_that_nobody_stated_is_written_nowhere(tmp_path, scripted, capsys):
    out = tmp_path / "front"
    done = scripted(out, "a q")
    assert f"mukca info {out} --set-distance" in done.output
    assert "distance" not in json.loads((out / "placement.json").read_text())
    assert scripted(out, "a q", "--distance", "0.1").status == 0
    assert (read(out).distance, read(out).distance_assumed) == (0.1, False)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("typed", "distance", "again"),
    [("far\r1\r100,08\r", 0.10008, "100.12"), ("0.1002\r", 0.1002, ""), ("\r", None, None)],
)
def test_the_distance_is_asked_for(hand, tmp_path, typed, distance, again):
    """Before the session, and once more after it; an empty answer keeps what is there."""
    out = tmp_path / "front"
    words = [word for word in command(hand, out) if word not in ("--distance", "0.05")]
    with TerminalSession(words) as terminal:
        terminal.wait_for("mm, or Enter for not yet measured")
        for line in typed.splitlines(keepends=True):
            terminal.press(line)
        terminal.wait_for("SOCKET 0", "sockets 100" if distance else "sockets unmeasured")
        terminal.press("q")
        if again is not None:
            terminal.wait_for("mm, or Enter for no second reading")
            terminal.press(f"{again}\r")
        assert terminal.wait() == 0
    written = json.loads((out / "placement.json").read_text())
    assert written.get("distance") == (float(again) / 1e3 if again else distance)
    assert readings_in(out) == tuple(d for d in (distance, again and float(again) / 1e3) if d)
    assert written.get("distance_measured") == (distance and True)


@pytest.mark.slow
@pytest.mark.parametrize(("typed", "distance"), [("\r", 0.05), ("100\r", 0.1)])
def test_another_distance_than_that_of_the_placement_before_is_asked_about(
    hand, tmp_path, scripted, typed, distance
):
    """One base has one distance; another base may have another."""
    front, left = tmp_path / "data/front", tmp_path / "data/left"
    assert scripted(front, "a q", "--distance", "0.05").status == 0
    with TerminalSession(command(hand, left, "--distance", "0.1")) as terminal:
        terminal.wait_for("front says 50 mm, this placement 100 mm", "mm, or Enter for 50")
        terminal.press(typed)
        terminal.wait_for("SOCKET 0", f"sockets {1e3 * distance:g} mm")
        terminal.press("q")
        assert terminal.wait() == 0
    assert json.loads((left / "placement.json").read_text())["distance"] == distance
    right = tmp_path / "data/right"
    with TerminalSession(command(hand, right)) as terminal:  # 50 mm, as in front
        shown = terminal.wait_for("SOCKET 0")
        assert "says" not in shown
        terminal.press("q")
        assert terminal.wait() == 0


def test_a_distance_is_corrected_and_what_it_was_stays_known(tmp_path, scripted, capsys):
    out = tmp_path / "front"
    assert scripted(out, "a q", "--distance", "0.05").status == 0
    assert main(["info", str(out), "--set-distance", "0.0502"]) == 0
    shown = capsys.readouterr().out
    assert f"distance changed from 50 mm to 50.2 mm in {out / 'placement.json'}" in shown
    assert "changed    distance from 50 mm to 50.2 mm, 2" in shown
    metadata = json.loads((out / "placement.json").read_text())
    assert metadata["distance"] == 0.0502
    assert metadata["changes"][0]["distance"] == [0.05, 0.0502]
    assert main(["info", str(out), "--set-distance", "0.0502"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("distance of 50.2 mm as before, and measured in ")
    assert "changed    distance of 50.2 mm as before, and measured, 2" in shown
    assert scripted(out, "a q").status == 0


def test_a_forgotten_out_is_called_by_its_name(session, tmp_path, scripted):
    assert scripted(tmp_path / "front", "a*2 q", hand=session / "front").status == 0
    done = scripted(tmp_path / "front", "a q", hand=session / "left")
    assert "! sample 3 puts the ball" in done.output
    assert "has the base moved? n: new placement" in done.output


def test_another_arm_is_called_by_its_name(tmp_path, scripted):
    """Where it moves beyond the model's limits."""
    hand = tmp_path / "low.csv"
    hand.write_text(",".join(map(repr, (*PANDA_HOME[:3], -2.6, *PANDA_HOME[4:]))))
    done = scripted(tmp_path / "front", "wait=1 !a q", "--robot", "iiwa14", hand=hand)
    assert re.search(r"! refused: .*outside its limits.* This moves like a .*panda", done.output)


def test_a_folder_of_placements_is_not_recorded_into(tmp_path, scripted):
    assert scripted(tmp_path / "data/front", "a q").status == 0
    done = scripted(tmp_path / "data", "a q")
    assert done.status == 2 and "holds placements (front)" in done.errors
    assert not (tmp_path / "data/samples.csv").exists()


@pytest.mark.slow
def test_marks_on_earlier_samples_count_and_stay_in_the_file(tmp_path, scripted):
    out = tmp_path / "front"
    done = scripted(out, "a*3 u r delete=1 relabel=2:1 q")
    assert done.status == 0 and "1 in socket 0, 1 in socket 1 (1 taken back)" in done.output
    assert [s.number for s in read(out).samples] == [2, 3]
    assert read(out).sockets.tolist() == [1, 0]
    events = [line.split(",")[0] for line in (out / "samples.csv").read_text().splitlines()[1:]]
    assert events == [*["capture"] * 3, "undo", "redo", "undo", "relabel"]
    again = scripted(out, "r delete=9 relabel=1:7 a q")
    assert len(read(out).samples) == 4
    assert "there is no sample 9" in again.output and "there is no socket 7" in again.output


@pytest.mark.slow
def test_what_is_continued_is_asked_about(hand, tmp_path, scripted):
    out = tmp_path / "front"
    assert scripted(out, "a*2 s a q").status == 0
    pedal = ["--key", "capture=Enter,PageDown", "--sound", "off"]
    with TerminalSession(command(hand, out, *pedal)) as terminal:
        terminal.wait_for(
            "GO ON?", "2 in socket 0, 1 in socket 1", "last in socket 1", "where it was?"
        )
        terminal.press("a")
        terminal.wait_for("GO ON?")
        terminal.press("n")
        terminal.wait_for("front-2", "SOCKET 0 NOW: once the ball is in socket 0: Enter")
        terminal.press("\r")
        capture(terminal, "\x1b[6~", "captured sample 1", called="Enter")
        terminal.press("q")
        assert terminal.wait() == 0
        assert b"\a" not in terminal.output
    assert len(read(out).samples) == 3
    assert len(read(tmp_path / "front-2").samples) == 1


@pytest.mark.slow
def test_two_recorders_cannot_share_a_folder(hand, tmp_path, scripted):
    out = tmp_path / "front"
    with TerminalSession(command(hand, out)) as terminal:
        terminal.wait_for("SOCKET 0")
        done = scripted(out, "a q")
        assert done.status == 2
        assert "another mukca record is writing there" in done.errors


def test_the_same_command_goes_on_where_the_base_was_last(tmp_path, scripted):
    out = tmp_path / "front"
    for folder in (out, tmp_path / "front-2"):
        assert scripted(folder, "a q").status == 0
    done = scripted(out, "q")
    assert "front was followed by front-2, which goes on" in done.output
    assert "continues a recording of 1 sample" in done.output
    assert "1 samples" not in done.output
    assert str(tmp_path / "front-2/samples.csv") in done.output
