"""The core verbs start and work without any extra, and without what only some systems have."""

import json
import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow

HEAVY = ("yourdfpy", "trimesh", "scipy", "networkx", "lxml", "shapely", "matplotlib", "PIL")
EXTRAS = (*HEAVY, "manifold3d", "rtde_receive", "roslibpy", "mujoco", "pinocchio", "OCP", "dask",
          "distributed", "isotp", "fpdf")  # fmt: skip
DRIVERS = ("serial", "can")
POSIX = ("termios", "tty", "pty", "fcntl", "resource", "pwd", "grp", "syslog", "readline")

# Runs a command where some modules cannot be imported, as where they are not installed.
WITHOUT = """
import sys
absent, linux_only, words = sys.argv[1].split(","), sys.argv[2].split(","), sys.argv[3:]
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in absent:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Absent())
for name in absent:
    sys.modules.pop(name, None)
import importlib.util
real = importlib.util.find_spec
importlib.util.find_spec = lambda name, *more: None if name in absent else real(name, *more)
import os, select, signal, socket
for module in (os, select, signal, socket):
    for name in linux_only:
        if hasattr(module, name):
            delattr(module, name)
from mukca.tools.cli import main
status = main(words)
found = sorted({name.split(".")[0] for name in sys.modules} & set(absent))
sys.exit(f"imported: {found}" if found else status)
"""
MACOS_HAS_NOT = ("pipe2", "epoll", "TCP_KEEPIDLE", "sched_getaffinity", "eventfd", "memfd_create")
WINDOWS_HAS_NOT = (*MACOS_HAS_NOT, "SIGHUP", "SIGQUIT", "SIGWINCH", "SIGALRM", "fork", "getuid",
                   "O_DIRECTORY", "O_CLOEXEC", "poll", "fpathconf", "AF_UNIX")  # fmt: skip


def run_without(absent, names, *words, cwd):
    lists = (",".join(absent), ",".join(names) or "nothing")
    command = [sys.executable, "-c", WITHOUT, *lists, *words]
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True)


def test_solve_and_report_need_no_extra_and_no_posix(session, tmp_path):
    out = tmp_path / "calibrated"
    words = ("solve", "front", "--test", "left", "--robot", "panda", "--out", str(out), "--json")
    absent = (*EXTRAS, *DRIVERS, *POSIX)
    result = run_without(absent, WINDOWS_HAS_NOT, *words, cwd=session)
    assert result.returncode in (0, 1) and "Traceback" not in result.stderr, result.stderr
    assert set(json.loads(result.stdout)["outputs"]) >= {"urdf", "report"}
    assert (out / "report.html").stat().st_size > 10_000


def test_check_needs_no_extra_and_no_posix(session):
    absent = (*EXTRAS, *DRIVERS, *POSIX)
    result = run_without(absent, WINDOWS_HAS_NOT, "check", "front", "--robot", "panda", cwd=session)
    assert result.returncode in (0, 1) and "Traceback" not in result.stderr, result.stderr
    assert not result.stderr.startswith("imported")


def test_recording_needs_no_extra_and_nothing_that_macos_has_not(session, tmp_path):
    driver, out = f"mock:{session / 'front'}?speed=20", str(tmp_path / "again")
    keys = tmp_path / "keys.txt"
    keys.write_text("a q")
    words = ("record", "--robot", "panda", "--driver", driver, "--out", out, "--keys", str(keys))
    result = run_without((*EXTRAS, *DRIVERS), MACOS_HAS_NOT, *words, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "1 in socket 0" in result.stderr + result.stdout


AS_ON_WINDOWS = """
import sys, types
from mukca.tools.cli import main
assert main([*sys.argv[1:], "first"]) == 0  # other packages' modules are loaded for this system
for name in ("termios", "tty", "pty", "fcntl", "resource", "pwd", "grp"):
    sys.modules[name] = None
locked = []
own = {"LK_NBLCK": 2, "locking": lambda *words: locked.append(words)}
sys.modules["msvcrt"] = types.SimpleNamespace(**own)
sys.platform = "win32"
assert main([*sys.argv[1:], "second"]) == 0 and locked
"""


def test_recording_asks_windows_for_what_it_has(session, tmp_path):
    (tmp_path / "keys.txt").write_text("a q")
    driver = f"mock:{session / 'front'}?speed=20"
    words = ("record", "--robot", "panda", "--driver", driver, "--keys", "keys.txt", "--out")
    command = [sys.executable, "-c", AS_ON_WINDOWS, *words]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert len((tmp_path / "second" / "samples.csv").read_text().splitlines()) == 2


@pytest.mark.parametrize(
    ("absent", "extra", "words"),
    [
        ("manifold3d", "print", "print-parts --out parts"),
        ("fpdf", "pdf", "report calibration.json --certificate sheet.pdf"),
    ],
)
def test_what_needs_an_extra_names_it(absent, extra, words, tmp_path):
    result = run_without((absent,), (), *words.split(), cwd=tmp_path)
    assert result.returncode == 2 and result.stderr.count("\n") == 1
    assert f"pip install 'mukca[{extra}]'" in result.stderr
