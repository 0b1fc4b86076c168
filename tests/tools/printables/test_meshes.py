"""Every part, at defaults and at extremes, is one printable body: trimesh and rays say so."""

import math

import mesh_checks
import numpy as np
import printed_parts
import pytest
import trimesh
from hypothesis import given, settings, strategies

from mukca.tools.printables import PrintableError, SocketBase, build_parts, encode

pytestmark = pytest.mark.slow

PARTS = [("base", name) for name in printed_parts.BASES] + [
    ("ball", name) for name in printed_parts.BALLS
]


@pytest.fixture(params=PARTS, ids=lambda part: f"{part[0]}: {part[1]}")
def part(request):
    return request.param


def mesh_of(part):
    kind, name = part
    return printed_parts.base_mesh(name) if kind == "base" else printed_parts.ball_mesh(name)


def test_a_part_is_one_closed_body_that_fits_the_printer(part):
    mesh = mesh_of(part)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.body_count == 1
    assert mesh.volume > 1000
    assert (mesh.extents <= 180.001).all()
    assert mesh.bounds[0, 2] == pytest.approx(0, abs=1e-5)
    assert mesh_checks.self_crossings(mesh) == 0
    assert mesh_checks.thinnest_wall(mesh) >= 1.2 - 1e-4


def test_a_part_leans_beyond_45_degrees_only_where_it_says(part):
    kind, name = part
    mesh = mesh_of(part)
    faces = mesh_checks.overhanging(mesh)
    named = printed_parts.ball(name).facts["overhangs"] if kind == "ball" else []
    assert bool(named) == (len(faces) > 0)
    for x, y, z in mesh.triangles_center[faces]:  # under the ball, beside its neck
        ball = printed_parts.BALLS[name]
        neck = math.sqrt((ball.ball / 2) ** 2 - (ball.throat / 2) ** 2)
        assert ball.ball / 2 * math.cos(math.pi / 4) - 0.1 <= ball.height - z <= neck + 0.1
        assert np.hypot(x, y) <= 0.36 * ball.ball


def test_the_volume_given_is_the_files(part):
    kind, name = part
    facts = (printed_parts.base(name) if kind == "base" else printed_parts.ball(name)).facts
    assert facts["volume"] * 1e9 == pytest.approx(mesh_of(part).volume, rel=1e-5)
    if kind == "ball":
        mount = printed_parts.BALLS[name].mount
        middle = 1000 * facts["centre_of_mass"][mount.axis] + mount.origin
        assert middle == pytest.approx(mesh_of(part).center_mass[2], abs=1e-3)
    assert np.array(facts["size"]) * 1e3 == pytest.approx(mesh_of(part).extents, abs=1e-3)


@settings(max_examples=4, deadline=None, derandomize=True)
@given(
    distance=strategies.floats(30, 155),
    sockets=strategies.sampled_from([2, 3]),
    ball=strategies.floats(10, 40),
    clearance=strategies.floats(0.3, 1),
    height=strategies.floats(25, 60),
)
def test_any_base_is_sound_or_refused(distance, sockets, ball, clearance, height):
    try:
        base = SocketBase(distance, sockets, ball, clearance, height)
    except PrintableError as error:
        assert "\n" not in str(error)
        return
    mesh = mesh_checks.load_stl(encode("stl", next(build_parts(base, {}))))
    assert mesh.is_watertight
    assert mesh.body_count == 1
    assert mesh_checks.self_crossings(mesh) == 0
    assert mesh_checks.thinnest_wall(mesh) >= 1.2 - 1e-4
    assert len(mesh_checks.overhanging(mesh)) == 0


def test_the_checks_see_what_they_look_for():
    box = trimesh.creation.box((10, 10, 10))
    moved = box.copy().apply_translation((5, 3, 8))
    assert mesh_checks.self_crossings(box) == 0
    assert mesh_checks.self_crossings(trimesh.util.concatenate([box, moved])) > 0
    assert mesh_checks.collide(box, moved)
    assert mesh_checks.collide(box, trimesh.creation.box((1, 1, 1)))
    assert not mesh_checks.collide(box, box.copy().apply_translation((10.01, 0, 0)))
    assert mesh_checks.thinnest_wall(trimesh.creation.box((10, 10, 1.1))) < 1.2
    assert len(mesh_checks.overhanging(moved)) == 2
