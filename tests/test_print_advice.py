"""docs/print.md and docs/balls.md say what the program does, and their figures are right."""

import re
from pathlib import Path

import numpy as np
import printed_parts
import pytest
from cases import by_table

from mukca.solver.identification.robot import load_robot, shipped_robots
from mukca.tools.cli import main
from mukca.tools.printables import MOUNTS, BallPart, PrintableError, SocketBase, build_parts

FOLDER = Path(__file__).parents[1] / "docs"
TEXT = "".join((FOLDER / f"{page}.md").read_text() for page in ("print", "balls"))
ROWS = [[cell.strip() for cell in line.split("|")[1:-1]] for line in TEXT.splitlines()]


def test_its_options_exist(capsys):
    with pytest.raises(SystemExit):
        main(["print-parts", "--help-all"])
    known = set(re.findall(r"--[a-z-]+", capsys.readouterr().out))
    named = set(re.findall(r"--[a-z-]+(?=[ `])", TEXT))
    assert len(named) > 8
    assert named <= known | {"--flange", "--ball", "--sockets-at"}


@pytest.mark.slow
@pytest.mark.parametrize("name", MOUNTS)
def test_its_mounts_are_those_that_are_made(name):
    part = BallPart(MOUNTS[name])
    row, payload = [row for row in ROWS if row and row[0] == f"`{name}`"]
    assert f"{part.position[part.mount.axis]:g} mm beyond" in row[2]
    assert row[3] == f"{part.bend:.3f} mm"
    assert payload[1:] == _payload(name)


@by_table("page", "mounts")
def test_pages_of_arms_say_what_to_tell_the_arm(page, mounts):
    text = " ".join((FOLDER / f"{page}.md").read_text().split())
    told = re.findall(r"weighs (\d+ g),(?: with its centre)? (\d+ mm) be", text)
    told += re.findall(r"plate (\d+ g), with its centre (\d+ mm) be", text)
    assert [list(pair) for pair in told] == [_payload(name) for name in mounts]


def _payload(name):
    part = printed_parts.ball(name)
    along = part.facts["centre_of_mass"][MOUNTS[name].axis]
    return [
        f"{1000 * part.facts['mass']['PLA']:.0f} g",
        f"{1000 * along:.0f} mm".replace("-0 ", "0 "),
    ]


def test_its_limits_of_distance_hold():
    low, high = map(float, re.findall(r"20 mm\s+allows ([\d.]+) to (\d\.\d+)", TEXT)[0])
    for distance in (low, high):
        SocketBase(distance=1000 * distance)
        with pytest.raises(PrintableError, match=r"overlap|larger"):
            SocketBase(distance=1000 * (distance + (0.001 if distance == high else -0.001)))


@pytest.mark.parametrize("robot", shipped_robots())
def test_the_ball_of_a_shipped_model_is_where_its_printed_mount_holds_it(robot):
    mount = next((m for m in MOUNTS.values() if m.links.get(robot)), None)
    if mount is None:
        pytest.skip("its maker publishes no frame at which a mount could be placed")
    ball = load_robot(robot).joints[-1]
    assert ball.parent == mount.links[robot]
    assert np.multiply(1000, ball.origin.xyz) == pytest.approx(BallPart(mount).position, abs=1e-6)


@pytest.mark.slow
def test_the_list_of_what_to_buy_holds_for_every_mount():
    """Grams of the lightest and the heaviest ball, and hours of the base and of both balls."""
    readme = (FOLDER.parent / "README.md").read_text()
    balls = [printed_parts.ball(name).facts for name in MOUNTS]
    base = next(build_parts(SocketBase(), {})).facts
    grams = [1000 * ball["mass"]["PLA"] for ball in balls]
    for page in (readme, TEXT):
        assert f"{1000 * base['mass']['PLA']:.0f} g for the base" in page
        assert f"{min(grams):.0f} to {max(grams):.0f} g for the ball" in page
    base_hours, *hours = [part["print_time"] / 3600 for part in (base, *balls)]
    times = f"{base_hours:.1f} hours, and the ball in {min(hours):.1f} to {max(hours):.1f}."
    assert times in " ".join(readme.split())
