"""The ball on its neck: where it is, how far it bends, how far it leans."""

import math
from itertools import product

import mesh_checks
import numpy as np
import printed_parts
import pytest
import trimesh
from cases import by_table

from mukca.tools.printables import (
    MOUNTS,
    SCREWS,
    BallPart,
    PrintableError,
    SocketBase,
    bolt_circle,
    build_parts,
)

pytestmark = pytest.mark.slow

ISO = MOUNTS["iso-50-4-m6"]
CIRCLES = {"iiwa14": (50, 8, "M6", 0), "gen3-lite": (32, 4, "M5", 10)}
PRINTED = [name for name, part in printed_parts.BALLS.items() if not part.bought]


@pytest.mark.parametrize("name", PRINTED)
def test_the_ball_is_where_its_position_says(name):
    part, mesh = printed_parts.BALLS[name], printed_parts.ball_mesh(name)
    top = mesh.vertices[mesh.vertices[:, 2] > part.height]
    centre, radius = mesh_checks.fit_sphere(top)
    assert centre == pytest.approx((0, 0, part.height), abs=0.005)
    assert radius == pytest.approx(part.ball / 2, abs=0.005)
    along, aside = part.mount.axis, part.mount.aside
    assert part.position[along] == pytest.approx(part.height - part.mount.origin)
    assert np.delete(part.position, along) == pytest.approx(aside)


def test_a_cup_holds_a_bought_ball_at_the_same_place():
    name = "iso-50-4-m6 bought"
    part, mesh = printed_parts.BALLS[name], printed_parts.ball_mesh(name)
    reach = np.linalg.norm(mesh.vertices - (0, 0, part.height), axis=1)
    cup = mesh.vertices[abs(reach - part.ball / 2 - 0.1) < 2e-4]
    centre, radius = mesh_checks.fit_sphere(cup)
    assert len(cup) > 100
    assert centre == pytest.approx((0, 0, part.height), abs=0.005)
    assert radius == pytest.approx(part.ball / 2 + 0.1, abs=0.005)
    assert part.position == printed_parts.BALLS["iso-50-4-m6"].position


def test_a_tapered_neck_bends_as_the_closed_form_says():
    """The integral of x²/(c + k x)⁴ is x³ / (3 c (c + k x)³)."""
    part = BallPart(ISO)
    start = math.sqrt(10**2 - (part.throat / 2) ** 2)
    k = (part.root - part.throat) / 2 / (part.length - start)
    c = part.throat / 2 - k * start
    integral = [x**3 / (3 * c * (c + k * x) ** 3) for x in (start, part.length)]
    expected = 5 / (2500 * math.pi / 4) * (integral[1] - integral[0])
    assert part.bend == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("name", printed_parts.BALLS)
def test_the_neck_of_the_mesh_is_the_one_that_was_reckoned_with(name):
    part, mesh = printed_parts.BALLS[name], printed_parts.ball_mesh(name)
    assert part.bend <= 0.05
    start = math.sqrt((part.ball / 2) ** 2 - (part.throat / 2) ** 2)
    for share in (0.02, 0.5, 0.98):
        below = start + share * (part.length - start)
        section = mesh.section(plane_origin=(0, 0, part.height - below), plane_normal=(0, 0, 1))
        reach = np.hypot(*section.vertices[:, :2].T)
        diameter = part.throat + share * (part.root - part.throat)
        assert 2 * reach.max() == pytest.approx(diameter, abs=0.01)


@by_table("name", "base")
def test_the_ball_part_leans_in_its_socket_without_collision(name, base):
    part, socket_base = printed_parts.BALLS[name], printed_parts.BASES[base]
    fixed, moving = printed_parts.base_mesh(base), envelope(name)
    spins = (0, 45, 90) if name == "franka-hand" else (0,)
    sockets = range(socket_base.sockets)
    farthest = product(sockets, (60,), range(0, 360, 30), spins)
    for where in (*farthest, *product(sockets, (20, 40), range(0, 360, 90), (0,))):
        assert not mesh_checks.collide(moving, fixed, seated(part, socket_base, *where)), where


@pytest.mark.parametrize("name", ["franka-hand", "iso-50-4-m6"])
def test_leaning_much_farther_collides(name):
    part, base = printed_parts.BALLS[name], printed_parts.BASES["default"]
    fixed = printed_parts.base_mesh("default")
    assert mesh_checks.collide(envelope(name), fixed, seated(part, base, 0, 85, 0, 0))


def envelope(name):
    """Return the ball part with the heads of its screws, and its ball where it is bought."""
    part = printed_parts.BALLS[name]
    bodies = [printed_parts.ball_mesh(name)]
    if part.bought:
        ball = trimesh.creation.icosphere(4, part.ball / 2)
        bodies.append(ball.apply_translation((0, 0, part.height)))
    if part.mount.hardware:
        diameter, count, size, slot = CIRCLES.get(name, (50, 4, "M6", 0))
        screw = SCREWS[size]
        for i, far in product(range(count), (0, slot)):
            head = trimesh.creation.cylinder(screw.head / 2, screw.height)
            angle, radius = 2 * math.pi * (i + 0.5) / count, diameter / 2 + far
            place = (radius * math.cos(angle), radius * math.sin(angle))
            bodies.append(head.apply_translation((*place, part.mount.top + screw.height / 2)))
    return trimesh.util.concatenate(bodies)


def seated(part, base, socket, tilt, azimuth, spin):
    """Return the pose of a ball part 0.05 mm above its seat, its neck up and leaning [deg]."""
    turn = trimesh.transformations.rotation_matrix
    a = math.radians(azimuth)
    pose = turn(math.radians(tilt), (-math.sin(a), math.cos(a), 0))
    pose = pose @ turn(math.radians(spin), (0, 0, 1)) @ turn(math.pi, (1, 0, 0))
    pose[:3, 3] = np.array((*base.centres[socket], base.height + 0.05))
    pose[:3, 3] -= pose[:3, :3] @ (0, 0, part.height)
    return pose


def test_too_short_a_reach_is_refused_with_one_that_works():
    short = BallPart(ISO, reach=45)
    with pytest.raises(PrintableError, match="take a reach of 70 mm or more"):
        list(build_parts(SocketBase(50.0), {"short": short}))
    assert len(list(build_parts(SocketBase(50.0), {"long": BallPart(ISO, reach=70)}))) == 2


def test_the_jaws_of_an_so101_lie_in_grooves():
    """16.5 mm wide at most, faces 40 mm apart; beside them there is material to stop a turn."""
    mesh = printed_parts.ball_mesh("so101")
    jaws = [(x, side * y) for x in (-8.2, 0, 8.2) for y in (20.1, 22) for side in (1, -1)]
    stops = [(side * 8.4, other * 21) for side in (1, -1) for other in (1, -1)]
    within = [(x, y) for x in (-15, 0, 15) for y in (-19.9, 0, 19.9)]
    for z in (0.5, 15, 29):
        for places, filled in ((jaws, False), (stops, True), (within, True)):
            inside = mesh.contains([(x, y, z) for x, y in places])
            assert (inside == filled).all(), (z, filled)


@pytest.mark.parametrize(
    ("diameter", "count", "screw", "slot"), [(50, 6, "M5", 0), (50, 8, "M6", 0), (32, 4, "M5", 10)]
)
def test_screws_find_their_holes(diameter, count, screw, slot):
    """Straight through the plate, at the circle, and through all of a slot's length."""
    part = BallPart(bolt_circle(diameter, count, screw, slot))
    made = printed_parts.made("screwed", part).mesh
    mesh = made
    for i in range(count):
        angle = 2 * math.pi * (i + 0.5) / count
        for radius in np.linspace(diameter / 2, diameter / 2 + slot, 5):
            x, y = radius * math.cos(angle), radius * math.sin(angle)
            assert not mesh.ray.intersects_any([(x, y, -5)], [(0, 0, 1)])[0]
