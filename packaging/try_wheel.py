"""Install a wheel with nothing else in empty environments, and do the main job there.

    python packaging/try_wheel.py mukca-*.whl [PYTHON ...]

For each Python: a new environment, the wheel and what it names, `mukca --version`, the same by
`python -m mukca`, `try_installed.py`, and `pip uninstall`; by the last Python under -OO, too. The
first that is ready runs `mukca demo`.
Without PYTHON: each version that the project supports and that is found here.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[1]
SCRIPT = Path(__file__).with_name("try_installed.py")
VERSIONS = ("3.10", "3.11", "3.12", "3.13")
DEMO = threading.Lock()
SHIPPED = re.compile(
    r"mukca/((drivers|recorder|solver|tools)/.*|\w+\.pyi?|py\.typed)$|mukca-[^/]*\.dist-info/"
)


def look_inside(wheel):
    """Refuse a wheel with tests, pages or examples, or of another size than docs/install.md has."""
    names = zipfile.ZipFile(wheel).namelist()
    strange = [name for name in names if not SHIPPED.match(name)]
    assert not strange, strange
    megabytes = f"the wheel has {wheel.stat().st_size / 1e6:.1f} MB"
    assert megabytes in (ROOT / "docs/install.md").read_text(), megabytes
    print(f"{wheel.name}: {len(names)} files, {wheel.stat().st_size / 1e3:.0f} kB")


def supported_pythons():
    """Return the interpreters of the supported versions, on PATH or among pyenv's."""
    installed = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    pythons = []
    for version in VERSIONS:
        of_pyenv = [str(python) for python in installed.glob(f"{version}.*/bin/python")]
        candidates = [*sorted(of_pyenv), shutil.which(f"python{version}")]
        python = next(
            (python for python in candidates if python and _runs(python)), None
        )
        if python:
            pythons.append(python)
        else:
            print(f"Python {version}: not found here, not tried")
    return pythons


def _runs(python):
    """Return whether an interpreter starts: pyenv has a name for versions that are not chosen."""
    return (
        subprocess.run([python, "-c", ""], capture_output=True, check=False).returncode
        == 0
    )


def try_with(python, wheel, shared, *, optimized):
    """Install the wheel for one Python, do the main job, and return what to say of it."""
    with tempfile.TemporaryDirectory() as name:
        environment = Path(name) / "env"
        inside, mukca = environment / "bin/python", environment / "bin/mukca"
        _run(name, python, "-m", "venv", "--without-pip", environment)
        pip = (sys.executable, "-m", "pip", "--python", inside)
        limits = ("--constraint", ROOT / "constraints.txt", "--quiet", "--no-compile")
        _run(name, *pip, "install", *limits, wheel)
        version = _run(name, mukca, "--version").strip()
        assert _run(name, inside, "-m", "mukca", "--version").strip() == version
        with DEMO:
            if not (shared / "demo").exists():
                _run(shared, mukca, "demo", "--out", "demo")
        lines = []
        for options in ([], ["-OO", "-B"])[: 1 + optimized]:  # pip leaves files of -OO
            folder = Path(name, *options, "results")
            folder.mkdir(parents=True)
            told = _run(folder, inside, *options, SCRIPT, shared / "demo/recordings")
            lines.append(" ".join([told.strip().splitlines()[-1], *options]))
        packages = json.loads(_run(name, *pip, "list", "--format", "json"))
        size = _run(name, "du", "-sm", environment).split()[0]
        lines.append(f"    {version}, {len(packages)} packages, {size} MB")
        _run(name, *pip, "uninstall", "--quiet", "--yes", "mukca")
        left = [*environment.rglob("mukca"), *environment.rglob("mukca-*")]
        assert not left, left
        lines.append("    uninstalled, and nothing of it stays")
        return "\n".join(lines)


def _run(folder, *words):
    """Run a program in a folder without the settings of this Python, and return what it says."""
    outside = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith("PYTHON")
    }
    words = [str(word) for word in words]
    result = subprocess.run(
        words, cwd=folder, env=outside, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, (words, result.stdout[-2000:], result.stderr[-4000:])
    return result.stdout


def try_all(wheel, pythons):
    """Do it by each Python, as many at once as there are processors."""
    with (
        ThreadPoolExecutor(os.cpu_count()) as threads,
        tempfile.TemporaryDirectory() as shared,
    ):
        tries = [
            threads.submit(
                try_with, python, wheel, Path(shared), optimized=python == pythons[-1]
            )
            for python in reversed(pythons)
        ]
        for attempt in tries:
            print(attempt.result(), flush=True)


if __name__ == "__main__":
    wheel, *pythons = sys.argv[1:]
    look_inside(Path(wheel).resolve())
    try_all(Path(wheel).resolve(), pythons or supported_pythons())
