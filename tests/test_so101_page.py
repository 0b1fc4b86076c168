"""docs/so101.md: its commands lead from the first sample to a PASS, on a simulated arm."""

import json
import math
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from altered import moved, write_samples
from recorded import recorded_at, true_arm
from worlds import realistic_flaws

from mukca.solver.identification.robot import load_robot
from mukca.tools.cli import main
from mukca.tools.recording import recorded_beside

PAGE = (Path(__file__).parents[1] / "docs" / "so101.md").read_text()
PLACES = {"front": (0.28, 0.0, 0.03), "left": (0.2, 0.16, 0.03), "right": (0.19, -0.17, 0.05)}
TURN = 6
"""Samples in a socket before it is the other's turn."""


def commands():
    """The commands of the steps on recording and solving, in their order."""
    steps = PAGE[PAGE.index("4. Print") : PAGE.index("Only where the socket base stands on")]
    fences = "\n".join(re.findall(r"```\n(.*?)```", steps, re.S))
    return [shlex.split(line)[1:] for line in fences.splitlines() if line.strip()]


def lead(folder):
    """Write where a hand leads an arm whose zeros, links, gears and encoders are off."""
    robot, generator = load_robot("so101"), np.random.default_rng(3)
    arm, zeros = true_arm(robot, generator, 3e-4), np.radians(generator.normal(0, 2, 5))
    flaws = realistic_flaws(robot, generator)
    flaws = replace(flaws, play=math.radians(0.2), resolution=2 * math.pi / 4096)
    for name, place in PLACES.items():
        led = recorded_at(arm, place, generator, name, 2 * TURN, 0.1001, imperfection=flaws)
        read = moved(led, led.positions + zeros).samples
        zero, one = read[: 2 * TURN], read[2 * TURN :]
        turns = (*zero[:TURN], *one[:TURN], *zero[TURN:], *one[TURN:])
        write_samples(folder / name, replace(led, samples=turns))


@pytest.mark.slow
@pytest.mark.usefixtures("virtual_time")
def test_the_page_leads_to_a_pass(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    lead(tmp_path / "hand")
    keys = tmp_path / "keys"
    keys.write_bytes(b"a*6 s  " * 3 + b"a*6 q\n")
    typed, told = commands(), ""
    assert [words[0] for words in typed] == [*["record"] * 3, "check", "solve"]
    for words in typed:
        if words[0] == "record":
            name = Path(words[words.index("--out") + 1]).name
            driver = f"mock:{tmp_path / 'hand' / name}?rate=100&speed=10&hold=0.65&move=0.6"
            words[words.index("--driver") + 1] = driver
            words += ["--keys", str(keys)]
        if words[0] == "solve":
            words.append("--json")
        assert main(words) == 0, capsys.readouterr()
        said = capsys.readouterr()
        if words[0] == "record":
            told = said.out + said.err
    both = "mukca solve recordings/front recordings/left recordings/right --robot so101 --zeros"
    assert both in " ".join(told.split())
    verdict = json.loads(said.out)["verdict"]
    assert verdict["status"] == "pass" and verdict["title"].startswith("PASS")
    beside = recorded_beside(tmp_path / "recordings" / "right", load_robot("so101"))
    assert [placement.name.rpartition("/")[2] for placement in beside] == ["front", "left"]
    assert not recorded_beside(tmp_path / "recordings" / "right", load_robot("so100"))
