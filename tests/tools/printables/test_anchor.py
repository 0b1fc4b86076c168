"""A base that clips to an arm's plate: it holds the plate, and says where its sockets then are."""

import json

import numpy as np
import printed_parts
import pytest
from manifold3d import CrossSection, Manifold, Mesh

from mukca.solver.identification.robot import load_robot, rotation_rpy
from mukca.solver.tables import read_sockets_at
from mukca.tools.printables import ARMS, AnchoredBase, build_parts

BASE = printed_parts.BASES["anchored"]
assert isinstance(BASE, AnchoredBase)


def plate(y, width=BASE.width):
    """The arm's plate with its front edge at y, in the part's frame."""
    corners = [(-width / 2, y - 60), (width / 2, y - 60), (width / 2, y), (-width / 2, y)]
    return Manifold.extrude(CrossSection([np.array(corners)]), 6)


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 1], ids=["base", "fit test"])
def test_the_clip_meets_the_plate_and_grips_it(number):
    mesh = list(build_parts(BASE, {}))[number].mesh
    body = Manifold(Mesh(np.float32(mesh.vertices), np.uint32(mesh.faces)))
    bumps = (body ^ plate(BASE.face)).volume()
    assert 0 < bumps < 2 * 6 * 6 * 0.4, "only the bumps press on it"
    narrow = BASE.width - 2 * 0.41
    assert (body ^ plate(BASE.face, narrow)).volume() == pytest.approx(0, abs=1e-6)
    stopped = (body ^ plate(BASE.face + 0.1, narrow)).volume()
    assert stopped > 0.09 * 3 * narrow, "the face stops it"


def test_the_sockets_are_where_the_arm_has_them():
    edge = ARMS["so101"].axis + BASE.front  # x of the plate's front edge in the arm's base frame
    for (x, y), (X, Y, Z) in zip(BASE.centres, BASE.sockets_in_base, strict=True):
        assert edge - X == pytest.approx(BASE.face - y)
        assert -x == pytest.approx(Y)
        assert pytest.approx(BASE.height) == Z
    assert BASE.sockets_in_base[0][1] > 0, "socket 0 is at the left of an arm that looks ahead"


@pytest.mark.parametrize("name", ARMS)
def test_axes_are_the_models(name):
    robot = load_robot(name)
    first, second = (robot.origins[robot.joints.index(joint)] for joint in robot.actuated[:2])
    assert 1e3 * first[:2] == pytest.approx([ARMS[name].axis, 0], abs=0.01)
    shoulder = first[:3] + np.array(rotation_rpy(first[3:].tolist())) @ second[:3]
    assert 1e3 * shoulder[2] == pytest.approx(ARMS[name].shoulder, abs=0.01)


def test_the_command_writes_what_solve_reads(tmp_path, command, refused):
    words = ["print-parts", "--out", tmp_path, "--mount", "none", "--format", "stl", "--json"]
    words += ["--anchor", "so101"]
    refused("--anchor goes with --plate-mm, which is not given", *words)
    status, out, err = command(*words, "--plate-mm", "80", "45")
    base, fit_test = json.loads(out)["parts"]
    assert status == 0
    parts = {f"{base['name']}.stl", f"{fit_test['name']}.stl"}
    assert {file.name for file in tmp_path.iterdir()} == parts | {"sockets-at-so101.csv"}
    read = read_sockets_at([tmp_path / "sockets-at-so101.csv"])
    assert [one.socket for one in read] == [("anchored", 0), ("anchored", 1)]
    assert {one.frame for one in read} == {"base"}
    places = [one.coordinates for one in read]
    assert np.array(places) == pytest.approx(np.array(base["sockets_in_base"]), abs=1e-6)
    assert "116.6 mm above the table" in err
