"""The folders below packaging/ hold together with the project."""

import importlib.metadata
import platform
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import jinja2
import pytest
from packaging.requirements import Requirement
from project import PROJECT, ROOT

import mukca

ROOMS = ("drivers", "recorder", "solver", "tools")
ROS = ROOT / "packaging" / "ros2" / "mukca_ros"


def test_the_recipe_requires_what_the_project_requires():
    recipe = jinja2.Template((ROOT / "packaging/conda/meta.yaml").read_text()).render(PYTHON="py")
    run = re.findall(r"^    - (.*)$", recipe.split("  run:\n")[1].split("\ntest:")[0], re.M)
    project = PROJECT["project"]
    plain = {re.sub(r"\s", "", need) for need in project["dependencies"] if ";" not in need}
    assert {need.replace(" ", "") for need in run} == plain | {
        f"python{project['requires-python']}"
    }
    assert f"mukca = {project['scripts']['mukca']}" in recipe


@pytest.mark.slow
def test_the_ros_package_installs_what_ament_looks_for(tmp_path):
    source, out = shutil.copytree(ROS, tmp_path / "mukca_ros"), tmp_path / "out"
    out.mkdir()
    steps = ["install_data", f"--install-dir={out}", "build_py", f"--build-lib={out}"]
    words = [sys.executable, "setup.py", "-q", *steps, "egg_info", f"--egg-base={out}"]
    subprocess.run(words, cwd=source, check=True, capture_output=True)
    assert (out / "share/ament_index/resource_index/packages/mukca_ros").is_file()
    assert (out / "share/mukca_ros/launch/calibrated.launch.py").is_file()
    entry = (out / "mukca_ros.egg-info/entry_points.txt").read_text()
    module, _, function = entry.split(" = ")[1].strip().partition(":")
    file = out.joinpath(*module.split(".")).with_suffix(".py")
    assert f"def {function}()" in file.read_text()
    package = ElementTree.parse(ROS / "package.xml").getroot()
    assert package.findtext("version") == mukca.__version__.partition("+")[0]
    assert package.findtext("export/build_type") == "ament_python"


def test_the_launch_file_feeds_the_urdf_with_the_corrected_states():
    launch = (ROS / "launch/calibrated.launch.py").read_text()
    node = (ROS / "mukca_ros/true_joint_states.py").read_text()
    assert '("joint_states", "joint_states_true")' in launch and '"joint_states_true"' in node


def requirements(name, extras=()):
    """Names of the packages that a package needs, itself included."""
    names, asked = set(), [(name, extras)]
    while asked:
        name, extras = asked.pop()
        for line in importlib.metadata.requires(name) or []:
            need = Requirement(line)
            is_asked = need.marker is None or any(
                need.marker.evaluate({"extra": extra}) for extra in ("", *extras)
            )
            if is_asked and need.name not in names:
                asked.append((need.name, need.extras))
        names.add(name)
    return names


@pytest.mark.skipif(platform.machine() != "x86_64", reason="sizes are those of Linux on x86-64")
def test_the_page_of_installing_has_the_size_of_each_package():
    """Of its files and those of what it brings, in the row of the first that brings them."""
    page = (ROOT / "docs/install.md").read_text().partition("## The Tab key")[0]
    rows = re.findall(r"^\| ([\w, -]+) \| ([\d.]+) \| ", page, re.M)
    counted, wrong = set(), {}
    for names, stated in rows:
        packages = set().union(*(requirements(name) for name in names.split(", "))) - counted
        counted |= packages
        files = [file.locate() for name in packages for file in importlib.metadata.files(name)]
        if names == "mukca":
            files = [file for room in ROOMS for file in (ROOT / room).rglob("*")]
        files = [file for file in files if file.is_file() and file.suffix != ".pyc"]
        size = sum(file.stat().st_size for file in files) / 1e6
        if abs(size - float(stated)) > max(0.1 * size, 0.2):
            wrong[names] = f"{size:.1f} MB"
    assert len(rows) > 7 and wrong == {}
