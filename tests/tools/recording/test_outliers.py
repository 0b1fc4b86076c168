"""Nominal models warn of a hand on the arm, and of a ball that was elsewhere."""

from pathlib import Path

import pytest
from record_commands import fast, read

from mukca.recorder import METADATA, SAMPLES, Placement, Sample, sample_files
from mukca.solver.data import Load
from mukca.solver.robot import Robot, gravity_torques


def hand_of(folder: Path, *samples: Sample) -> Path:
    """A recording that a simulated arm replays."""
    folder.mkdir()
    for name, content in sample_files(Placement("hand", samples)).items():
        (folder / name).write_bytes(content)
    assert (folder / SAMPLES).exists() and not (folder / METADATA).exists()
    return folder


@pytest.mark.parametrize(
    ("load", "more", "fault", "told"),
    [
        (Load(), [], "", False),
        (Load(), [], "&fault=push@0+inf", True),
        (Load(gravity=(0.0, 9.81, 0.0)), [], "", True),
        (Load(gravity=(0.0, 9.81, 0.0)), ["--gravity", "0", "9.81", "0"], "", False),
    ],
)
def test_a_hand_is_noticed_by_efforts_beyond_gravity(
    panda: Robot, session: Path, tmp_path: Path, scripted, load: Load, more: list[str],
    fault: str, told: bool,
) -> None:  # fmt: skip
    first = read(session / "front").samples[0]
    torques = gravity_torques(panda, read(session / "front").positions[:1], load.gravity)[0]
    sample = Sample(first.position, 0, tuple(torques.tolist()), number=1)
    hand, out = hand_of(tmp_path / "hand", sample), tmp_path / "front"
    driver = fast(hand, out)[fast(hand, out).index("--driver") + 1] + fault
    done = scripted(out, "a q", "--driver", driver, *more)
    assert done.status == 0, done.errors
    assert ("while the arm was pushed (panda_joint" in done.output) == told
    assert len(read(out).efforts[0]) == 7


@pytest.mark.slow
def test_a_sample_of_the_other_socket_is_suspected_and_no_other(
    session: Path, tmp_path: Path, scripted
) -> None:
    done = scripted(tmp_path / "front", "a*12 1 a*11 0 a q", hand=session / "front")
    assert done.output.count("puts the ball") == 1
    assert "mm from the others of socket 0: is it seated, and in socket 0?" in done.output


def test_few_samples_are_judged_by_less(session: Path, tmp_path: Path, scripted) -> None:
    first, second, *_ = read(session / "front").samples
    elsewhere = read(session / "left").samples[0]
    hand = hand_of(tmp_path / "hand", first, elsewhere, second)
    done = scripted(tmp_path / "one", "a*2 q", hand=hand)
    assert "! sample 2 puts the ball" in done.output and "from the others of soc" in done.output
    done = scripted(tmp_path / "two", "a 1 a q", hand=hand)
    assert "mm from the other socket: is it seated, and in socket 1?" in done.output
