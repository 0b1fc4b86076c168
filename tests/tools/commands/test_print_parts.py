"""``mukca print-parts`` as people and scripts use it."""

import contextlib
import io
from pathlib import Path

import mesh_checks
import pytest

from mukca import load_robot
from mukca.tools.cli import main

pytestmark = pytest.mark.slow


def run(*words):
    return main(["print-parts", *map(str, words)])


@pytest.mark.parametrize("mount", ["franka-hand", "panda"])
def test_one_command_writes_the_base_and_the_ball(tmp_path, capsys, mount):
    """A part has one name, by whichever of its names it was asked for."""
    assert run("--out", tmp_path / "parts", "--mount", mount) == 0
    shown = capsys.readouterr().out
    assert sorted(file.name for file in (tmp_path / "parts").iterdir()) == [
        "ball-franka-hand.3mf", "ball-franka-hand.stl", "ball-franka-hand.svg",
        "socket-base-2x100mm.3mf", "socket-base-2x100mm.stl", "socket-base-2x100mm.svg",
    ]  # fmt: skip
    assert "--robot panda --flange panda_hand_tcp --ball 0 0 0.03 --tip printed_ball\n" in shown
    assert "bends 0.007 mm under 5 N" in shown
    assert "124.00 mm around two waists and 76.00 mm between them" in shown
    mesh = mesh_checks.load_stl((tmp_path / "parts" / "ball-franka-hand.stl").read_bytes())
    assert mesh.bounds[1, 2] == pytest.approx(9.5 + 30 + 10, abs=1e-3)


@pytest.fixture(scope="module")
def everything(shared):
    """A folder with all parts, and what was said about them."""

    def make(folder):
        with contextlib.redirect_stdout(io.StringIO()) as shown:
            assert run("--out", folder / "files", "--format", "stl") == 0
        (folder / "shown").write_text(shown.getvalue())

    folder = shared("parts", make)
    return folder / "files", (folder / "shown").read_text()


def test_without_a_mount_all_of_them_are_written(everything):
    assert sorted(file.stem for file in everything[0].iterdir()) == [
        "ball-franka-flange", "ball-franka-hand", "ball-gen3-lite", "ball-iiwa14",
        "ball-interbotix", "ball-iso-50-4-m6", "ball-iso-80-6-m8", "ball-robotiq-2f-85",
        "ball-so101", "ball-strap", "ball-ufactory-gripper", "ball-xarm", "socket-base-2x100mm",
    ]  # fmt: skip


def test_json_is_one_object_in_metres(tmp_path, answer):
    words = ("--distance", 0.12, "--mount", "iso-50-4-m6", "--format", "stl")
    printed = answer("print-parts", "--out", tmp_path, *words)
    base, ball = printed["parts"]
    assert base["name"] == "socket-base-2x120mm"
    assert base["sockets"] == [[-0.06, 0.0, 0.03], [0.06, 0.0, 0.03]]
    assert base["caliper"] == {"outside": 0.144, "inside": 0.096}
    assert ball["ball"] == [0.0, 0.0, 0.07]
    assert 1e-5 < ball["bend"] <= 5e-5
    assert ball["flanges"]["ur5e"] == "tool0"
    assert printed["outputs"] == [
        str(tmp_path / "socket-base-2x120mm.stl"),
        str(tmp_path / "ball-iso-50-4-m6.stl"),
    ]
    assert all(Path(file).exists() for file in printed["outputs"])


def test_a_mount_of_ones_own(tmp_path, answer):
    circle = ("--bolt-circle-mm", 31.5, "--bolts", 3, "--screw", "M5")
    grip = ("--grip-mm", 12, 20, 25)
    words = ("--out", tmp_path, *circle, *grip, "--format", "stl")
    _, plate, block = answer("print-parts", *words)["parts"]
    assert (plate["name"], block["name"]) == ("ball-bolt-circle", "ball-gripper")
    assert plate["size"][0] == pytest.approx(0.0315 + 0.0085 + 0.003, abs=1e-5)
    assert block["ball"][2] == pytest.approx(0.025)


def test_nothing_is_overwritten_without_force(tmp_path, refused):
    words = ("--out", tmp_path, "--mount", "none", "--format", "stl")
    assert run(*words) == 0
    file = tmp_path / "socket-base-2x100mm.stl"
    file.write_bytes(b"mine")
    says = f"mukca print-parts: {file}: exists; choose another, or overwrite it by --force\n"
    assert refused(says, "print-parts", *words) == says
    assert file.read_bytes() == b"mine"
    assert run(*words, "--force") == 0
    assert len(file.read_bytes()) > 100_000
    assert [file.name for file in tmp_path.iterdir()] == ["socket-base-2x100mm.stl"]
    assert run(*words, "--distance", 0.05) == 0  # other parts may lie in the folder
    assert len(list(tmp_path.iterdir())) == 2


def test_the_places_put_the_ball_onto_the_shipped_models(everything, answer):
    """The words that are shown are accepted, and the ball comes out where they say."""
    lines = [line for line in everything[1].splitlines() if "place: --robot " in line]
    names = set()
    for line in lines:
        words = line.split()[1:]
        option = {name: words[words.index(name) + 1] for name in ("--robot", "--flange", "--tip")}
        at = words.index("--ball")
        x, y, z = map(float, words[at + 1 : at + 4])
        if option["--flange"] == "LINK":
            assert option["--robot"] == "so100|koch|openarm|wxai"
            continue
        for name in option["--robot"].split("|"):
            robot = load_robot(name, flange=option["--flange"], ball=(x, y, z), tip=option["--tip"])
            assert robot.joints[-1].origin.xyz == (x, y, z)
            names.add(name)
    shipped = {robot["name"] for robot in answer("robots")["robots"]}
    assert names <= shipped
    assert shipped - names == {*("so100", "koch", "openarm", "wxai")}, (
        "a flange or a gripper that was measured by nobody here"
    )
