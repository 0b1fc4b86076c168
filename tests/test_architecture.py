"""The house: which room may import from which, and what is shipped."""

import ast
import re
import sys
from pathlib import Path

import pytest

import mukca

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[1]
ROOMS = ("drivers", "recorder", "solver", "tools")
FILES = [file for room in ROOMS for file in sorted((ROOT / room).rglob("*.py"))]


def imports(file: Path) -> list[str]:
    """The package's modules that a file imports anywhere, as dotted paths below the root."""
    package = file.relative_to(ROOT).parts[:-1]
    modules: list[str] = []
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = package[: len(package) - node.level + 1]
            module = ".".join([*base, *(node.module or "").split(".")]).strip(".")
            modules += [module] if node.module else [f"{module}.{a.name}" for a in node.names]
        elif isinstance(node, ast.ImportFrom | ast.Import):
            names = (
                [node.module] if isinstance(node, ast.ImportFrom) else [a.name for a in node.names]
            )
            assert not any((name or "").split(".")[0] == "mukca" for name in names), file
    return [module.strip(".") for module in modules]


@pytest.mark.parametrize("file", FILES, ids=lambda f: str(f.relative_to(ROOT)))
def test_data_flows_one_way_through_the_rooms(file: Path) -> None:
    room = file.relative_to(ROOT).parts[0]
    for module in imports(file):
        other = module.split(".")[0]
        if other in ROOMS:
            assert ROOMS.index(other) <= ROOMS.index(room), f"{file}: {module} is above {room}"


@pytest.mark.parametrize("file", sorted((ROOT / "solver").rglob("*.py")), ids=lambda f: f.name)
def test_the_solver_sees_neither_driver_nor_terminal(file: Path) -> None:
    allowed = {"recorder.dataset", "recorder"}
    outside = {m for m in imports(file) if m.split(".")[0] in ROOMS and not m.startswith("solver")}
    assert outside <= allowed


def test_every_folder_with_code_is_shipped() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    shipped = set(project["tool"]["setuptools"]["packages"])
    folders = {".".join(["mukca", *file.relative_to(ROOT).parts[:-1]]) for file in FILES}
    assert folders | {"mukca"} == shipped


def test_the_root_holds_no_other_module() -> None:
    assert {file.name for file in ROOT.glob("*.py")} == {
        "__init__.py",
        "__main__.py",
        "_version.py",
        "errors.py",
    }


@pytest.mark.slow
def test_only_the_command_line_prints() -> None:
    for file in FILES:
        calls = [n for n in ast.walk(ast.parse(file.read_text())) if isinstance(n, ast.Call)]
        printing = [c for c in calls if isinstance(c.func, ast.Name) and c.func.id == "print"]
        assert not printing, file


def test_no_message_points_into_a_folder_that_is_not_installed() -> None:
    """The pages of docs/ come with the repository, not with the package."""
    for file in FILES:
        if "docs/" in (source := file.read_text()):
            values = [n.value for n in ast.walk(ast.parse(source)) if isinstance(n, ast.Constant)]
            shown = [v for v in values if isinstance(v, str) and "\n" not in v]
            assert not [text for text in shown if re.search(r"\bdocs/", text)], file


def test_constraints_pin_every_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pinned = {line.split("==")[0].lower().replace("_", "-") for line in lines if "==" in line}
    extras = project["optional-dependencies"].values()
    for requirement in [*project["dependencies"], *(r for extra in extras for r in extra)]:
        name = re.split("[^\\w.-]", requirement)[0]
        name = name.lower().replace("_", "-")
        assert name == "mukca" or name in pinned, requirement


def test_the_version_stands_in_one_place() -> None:
    version = mukca.__version__
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()
    assert version not in (ROOT / "pyproject.toml").read_text()
    assert not [file for file in FILES if f'"{version}"' in file.read_text()]


def test_workflows_call_the_makefile_and_nothing_else() -> None:
    targets = re.findall(r"^(\w[\w-]*):", (ROOT / "Makefile").read_text(), re.M)
    for file in (ROOT / ".github" / "workflows").glob("*.yml"):
        runs = re.findall(r"- run: (.*)", file.read_text())
        assert runs and all(re.fullmatch(r"make (\w+)", run)[1] in targets for run in runs)
