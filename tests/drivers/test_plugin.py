"""Arms of third parties: the example is used as its readme says, and broken ones are named."""

import ast
import json
import os
import re
import shutil
import subprocess
import sys

import pytest
from plugins import lay_out
from project import ROOT, tomllib

pytestmark = pytest.mark.slow

EXAMPLE = ROOT / "examples" / "plugin"
PAGE = ROOT / "docs" / "new-arm.md"


def run(*words, path, status=0):
    """Run Python with a folder of installed packages on its path."""
    environment = {**os.environ, "PYTHONPATH": str(path), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([sys.executable, *words], env=environment, capture_output=True, text=True)
    assert done.returncode == status, done.stdout + done.stderr
    return done


def listed(path):
    """Return what `mukca drivers` lists, by name, and its warnings."""
    done = run("-m", "mukca", "drivers", "--json", path=path)
    drivers = json.loads(done.stdout)["drivers"]
    return {driver["name"]: driver for driver in drivers}, done.stderr.splitlines()


def test_the_example_is_installed_listed_opened_and_its_own_tests_pass(tmp_path):
    """By pip, into a folder of its own; among its tests is the contract, which mukca brings."""
    source, site = shutil.copytree(EXAMPLE, tmp_path / "plugin"), tmp_path / "site"
    pip = (sys.executable, "-m", "pip", "install", "--no-deps", "--quiet", "--target")
    subprocess.run([*pip, str(site), str(source)], check=True)
    heron = listed(site)[0]["heron"]
    assert (heron["source"], heron["broken"]) == ("mukca-heron 1.0", None)
    assert heron["arms"] == "A Heron that streams its state."
    told = run("-m", "mukca", "stream", "--driver", "heron:127.0.0.1:9", path=site, status=2)
    assert told.stderr == (
        "mukca stream: 127.0.0.1:9 refused the connection: is the Heron switched on?\n"
    )
    options = ("-p", "no:cacheprovider", "-p", "no:xdist", "-q", "--rootdir", str(EXAMPLE))
    done = run("-m", "pytest", *options, str(EXAMPLE / "tests"), path=site)
    assert "23 passed, 1 skipped" in done.stdout


def test_the_page_shows_a_package_that_can_be_built():
    """Its pyproject.toml says what the example's says, and has all that pip needs."""
    (block,) = re.findall(r"```toml\n(.*?)```", PAGE.read_text(), re.DOTALL)
    shown, example = tomllib.loads(block), tomllib.loads((EXAMPLE / "pyproject.toml").read_text())
    for part in ("build-system", "tool"):
        assert shown[part] == example[part]
    assert shown["project"].items() <= example["project"].items()
    assert {"name", "version", "entry-points"} <= shown["project"].keys()


def test_the_page_shows_the_example_s_class():
    """But for types and comments, which the page leaves out."""
    (block,) = re.findall(r"```python\n(class Heron\(.*?)```", PAGE.read_text(), re.DOTALL)
    assert body_of(block) == body_of((EXAMPLE / "mukca_heron" / "driver.py").read_text())


def body_of(code):
    """Return what the class's methods that both have do, without types."""
    (heron,) = [node for node in ast.parse(code).body if isinstance(node, ast.ClassDef)]
    return {
        method.name: [ast.dump(statement) for statement in method.body]
        for method in heron.body
        if isinstance(method, ast.FunctionDef) and method.name != "_greeting"
    }


BROKEN = {
    "raises": ("raise RuntimeError('no licence')", "no licence"),
    "leaves": ("raise SystemExit(3)", "SystemExit(3)"),
    "lacks": ("import a_package_that_is_nowhere", "a_package_that_is_nowhere"),
    "empty": ("", "has no attribute 'Arm'"),
    "other": ("Arm = dict", "is no subclass of Driver"),
}
"""The code of each, and what is told of it."""


@pytest.fixture(scope="module")
def broken(tmp_path_factory):
    """Plug-ins, each broken in its own way, as pip would lay them out."""
    folder = tmp_path_factory.mktemp("broken")
    for name, (code, _) in BROKEN.items():
        lay_out(folder, f"plugin-{name}", code, {f"broken-{name}": "Arm"})
    lay_out(folder, "plugin-taken", "", {"franka": "Arm"})  # an arm that mukca brings
    return folder


def test_broken_plugins_are_named_and_stop_no_other(broken):
    drivers, warnings = listed(broken)
    assert drivers["ur"]["broken"] is drivers["mock"]["broken"] is None
    for name, (_, expected) in BROKEN.items():
        assert f"plugin-{name} 0.1" in drivers[f"broken-{name}"]["broken"]
        (warning,) = [line for line in warnings if f"'broken-{name}'" in line]
        assert expected in warning


def test_a_broken_plugin_is_told_in_one_line_and_takes_no_other_s_name(broken):
    done = run("-m", "mukca", "stream", "--driver", "broken-leaves:x", path=broken, status=2)
    (line,) = done.stderr.splitlines()
    assert "plugin-leaves 0.1" in line
    done = run("-m", "mukca", "stream", "--driver", "franka:127.0.0.1:9", path=broken, status=2)
    assert "activate FCI in Desk" in done.stderr
