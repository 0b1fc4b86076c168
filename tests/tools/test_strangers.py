"""What a stranger wrote steers no terminal, runs no program, and opens no other file."""

import json
import os
import re
import shutil
import subprocess
import sys
from types import SimpleNamespace

import pytest
from emulator_programs import emulated_program
from project import ROOT
from terminal_session import PATIENCE

from mukca.drivers import open_driver
from mukca.recorder import Sample
from mukca.recorder.session import Advice, Message, Session, View
from mukca.recorder.stream import JointLimits
from mukca.recorder.terminal import Lines, render
from mukca.tools.cli import Terminal
from mukca.tools.report.figures import collect

TITLE, CLIPBOARD, HIDDEN = "\x1b]0;mine\x07", "\x1b]52;c;ZWNobw==\x07", "\x1b[8m"
STEERING = f"{TITLE}{CLIPBOARD}{HIDDEN}\x9b2J\x7f\r\u202e\u2066"
"""Sets a window's title and the clipboard, hides, clears, deletes, overwrites, and turns text."""
STYLE = re.compile(r"\x1b\[[0-7;]*m")
"""What mukca itself sends."""


def assert_clean(text):
    assert HIDDEN not in text
    assert not set(STYLE.sub("", text)) & set("\x1b\x07\x9b\r\u202e\u2066")


def altered(value):
    """Return JSON in which each text that no code reads ends in what steers."""
    if isinstance(value, dict):
        return {key: altered(item) for key, item in value.items()}
    return value + STEERING if isinstance(value, str) else value


@pytest.fixture(scope="module")
def strange(session, cal, tmp_path_factory):
    """A folder of recordings, a calibration, a table and a model, all by a stranger."""
    folder = tmp_path_factory.mktemp("strange")
    for name in ("front", "left"):
        placement = shutil.copytree(session / name, folder / f"in {STEERING}" / f"{name}{STEERING}")
        file = placement / "placement.json"
        content = json.loads(file.read_text()) if file.exists() else {}
        kept = {key: content[key] for key in ("units", "joints") if key in content}
        notes = {"robot": "panda", "operator": "me", "driver": "mock", "distance_by": "caliper"}
        file.write_text(json.dumps({**altered({**notes, **content}), **kept}))
    shutil.copytree(cal, folder / "cal")
    file = folder / "cal" / "calibration.json"
    text = re.sub('"(panda|left)"', lambda name: json.dumps(name[1] + STEERING), file.read_text())
    file.write_text(text)
    joints = ",".join(f"q{i}mine\u202e" for i in range(7))  # all of it that a table may hold
    (folder / "table").mkdir()
    rows = "0.1,0.2,0.3,0.4,0.5,0.6,0.7\n" * 9
    (folder / "table" / "hole_0.csv").write_text(f"{joints}\n{rows}", encoding="utf-8")
    (folder / "table" / "hole_1.csv").write_text(f"{joints}\n{rows}", encoding="utf-8")
    in_text = "\x9b2J\u202e"
    joint = f'<joint name="a" type="revolute"><parent link="b"/><child link="c{in_text}"/></joint>'
    model = f'<robot name="r"><link name="b"/><link name="c{in_text}"/>{joint}</robot>'
    (folder / "model.urdf").write_text(model, encoding="utf-8")
    return folder


VERBS = {
    "info": ("info", "IN"),
    "check": ("check", "IN", "--robot", "panda"),
    "solve": ("solve", "IN", "--robot", "panda", "--out", "OUT"),
    "solve in short": ("solve", "IN", "--robot", "panda", "--out", "OUT", "--json"),
    "report": ("report", "DIR/cal", "--out", "OUT"),
    "a table": ("info", "DIR/table"),
    "a model": ("check", "IN", "--robot", "DIR/model.urdf"),
    "no folder": ("check", "DIR/none" + STEERING, "--robot", "panda"),
    "no verb": ("verb" + STEERING,),
    "no option": ("check", "--option" + STEERING),
    "no robot": ("check", "IN", "--robot", "arm" + STEERING),
}


@pytest.mark.slow
@pytest.mark.parametrize("colour", [False, True])
@pytest.mark.parametrize("name", VERBS)
def test_no_text_of_a_stranger_steers_the_terminal(
    command, strange, tmp_path, monkeypatch, name, colour
):
    if colour:
        monkeypatch.setenv("FORCE_COLOR", "1")
    stands_for = {"IN": next(strange.glob("in *")), "OUT": tmp_path / f"out{STEERING}"}
    words = [str(stands_for.get(word, word)).replace("DIR", str(strange)) for word in VERBS[name]]
    _, out, err = command(*words)
    assert "2J" in out + err or "mine" in out + err, out + err
    assert_clean(out)
    assert_clean(err)


def test_json_keeps_the_text_itself(capsys):
    Terminal(json=True).emit({"text": STEERING})
    out, _ = capsys.readouterr()
    assert_clean(out)
    assert json.loads(out)["text"] == STEERING


def view():
    session = Session((JointLimits(f"j{STEERING}", -2.0, 2.0),), sockets=2)
    message = Message(f"refused {STEERING}", alarm=True)
    sample = Sample((0.1,), 0, number=1, states=300, spread=(1e-5,))
    session = session.captured(sample)
    object.__setattr__(session, "messages", (*session.messages, message))
    advice = Advice(1, 0, 0.1, 0.1, target=(0.2,), closing=(STEERING,))
    facts = {"trouble": f"no {STEERING}", "page": STEERING, "typed": f"m{STEERING}_   x"}
    return View(session, position=(0.3,), rate=1e3, age=0.0, title=STEERING, advice=advice, **facts)


@pytest.mark.parametrize("width", [40, 80])
def test_the_recorders_screen_shows_it_and_obeys_it_not(width):
    lines = render(view(), width, 24)
    text = "".join(line.plain for line in lines)
    assert "\n" not in text and "?" in text
    assert_clean(text)


def test_lines_of_the_recorder_obey_it_not(capsys):
    Lines(Terminal().console).show(view())
    out, _ = capsys.readouterr()
    assert "refused ?]0;mine?" in out
    assert_clean(out)


PROGRAM = """
import sys
del sys.path[0]
from mukca import __main__
from mukca.tools import cli
from mukca.tools.parallel import Workers
cli.main = lambda: print(Workers(2).map(str, [1, 2])) or 0
__main__.run()
"""
MODULES = ("numpy", "rich", "pickle", "socket", "rtde_receive")


@pytest.fixture
def trap(tmp_path):
    """A folder of modules that tell when they are run."""
    for name in MODULES:
        (tmp_path / f"{name}.py").write_text("open('ran', 'w')\n")
    return tmp_path


STARTS = [
    ("-m", "mukca", "check", "nowhere", "--robot", "panda"),
    pytest.param(
        ("-c", PROGRAM),
        marks=pytest.mark.skipif(sys.version_info < (3, 11), reason="no PYTHONSAFEPATH"),
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize("words", STARTS)
def test_no_module_of_the_current_folder_is_run(trap, words):
    environment = {name: text for name, text in os.environ.items() if name != "PYTHONSAFEPATH"}
    path = os.pathsep.join([str(ROOT.parent), environment.get("PYTHONPATH", "")])
    environment["PYTHONPATH"] = path.rstrip(os.pathsep)  # an empty entry is the current folder
    command = [sys.executable, *words]
    done = subprocess.run(command, cwd=trap, env=environment, capture_output=True, text=True)
    assert not (trap / "ran").exists()
    assert "nowhere" in done.stderr or done.stdout == "['1', '2']\n", done.stderr


@pytest.mark.slow
def test_ur_rtde_comes_from_no_current_folder(trap, monkeypatch):
    pytest.importorskip("rtde_receive", reason="ur-rtde has no wheel for this Python")
    with emulated_program("ur", trap) as emulation:
        monkeypatch.chdir(trap)
        with open_driver("ur-rtde", emulation.host) as driver:
            driver.read(PATIENCE)
    assert not (trap / "ran").exists()


def meshes_read(folder, *names):
    """Return the frames that have a shape, of a model in a folder that names some mesh files."""
    shapes = [f'<visual><geometry><mesh filename="{name}"/></geometry></visual>' for name in names]
    text = f'<robot name="r"><link name="a">{"".join(shapes)}</link></robot>'
    model = SimpleNamespace(nominal_urdf=text, source=str(folder / "robot.urdf"))
    robot = SimpleNamespace(base="a", joints=())
    return [mesh.frame for mesh in collect.link_meshes(model, robot)]


def test_a_mesh_is_read_only_from_the_models_own_folders(tmp_path, caplog):
    import trimesh

    package = tmp_path / "arm"
    (package / "urdf").mkdir(parents=True)
    (package / "package.xml").touch()
    for file in (package / "ball.stl", tmp_path / "secret.stl", tmp_path / "secret.glb"):
        trimesh.creation.icosphere(subdivisions=1).export(file)
    (package / "link.stl").symlink_to(tmp_path / "secret.stl")
    (package / "ball.glb").write_bytes((tmp_path / "secret.glb").read_bytes())
    for name in ("../ball.stl", "package://arm/ball.stl", str(package / "ball.stl")):
        assert meshes_read(package / "urdf", name) == [0]
    assert meshes_read(package / "urdf", "../ball.glb") == []
    assert not caplog.records
    outside = ["../../secret.stl", f"{tmp_path}/secret.stl", f"file://{tmp_path}/secret.stl"]
    for name in (*outside, "../link.stl", "package://arm/../../secret.stl"):
        caplog.clear()
        assert meshes_read(package / "urdf", name) == []
        assert name in caplog.text and "\n" not in caplog.records[0].message
    assert meshes_read(package / "urdf", "package:///tmp/secret.stl") == []
