"""The house: which room may import from which, and what is shipped."""

import ast
import importlib
import importlib.util
import re
from functools import cache

import pytest
from closure import closure, parsed, tokens
from project import PROJECT, ROOT

import mukca

ROOMS = ("drivers", "recorder", "solver", "tools")
FILES = [file for room in ROOMS for file in sorted((ROOT / room).rglob("*.py"))]
FOLDERS = sorted({file.parent for file in FILES})
READING = {
    "cells",
    "columns",
    "coordinates",
    "dataset",
    "files",
    "placement",
    "placement_names",
    "recording_error",
    "sample",
    "samples",
    "tables",
    "turns",
    "words",
}
"""Files of the recorder that read recordings and tables; none knows a driver or a screen."""

CLOSURES = {
    "solver/identification/inference/map_estimate.py": (56, 48_700),
    "solver/identification/robot_fit.py": (63, 55_300),
    "solver/calibration/robot_calibration.py": (99, 87_000),
}
"""The most files and tokens that a module may need, itself among them: these only fall."""


def face(folder):
    """The names that a folder offers, each with the module that it comes from."""
    tree = ast.parse((folder / "__init__.pyi").read_text())
    rows = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    return {alias.name: node.module or "" for node in rows for alias in node.names}


@cache
def imports(file):
    """The package's modules that a file imports anywhere, as dotted paths below the root."""
    package = file.relative_to(ROOT).parts[:-1]
    modules = []
    for node in ast.walk(parsed(file)):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = package[: len(package) - node.level + 1]
            path = [word for word in [*base, *(node.module or "").split(".")] if word]
            for alias in node.names:
                folder = ROOT.joinpath(*path, alias.name).is_dir()
                modules.append(".".join([*path, alias.name] if folder else path))
        elif isinstance(node, ast.ImportFrom | ast.Import):
            names = (
                [node.module] if isinstance(node, ast.ImportFrom) else [a.name for a in node.names]
            )
            assert not any((name or "").split(".")[0] == "mukca" for name in names), file
    return [module.strip(".") for module in modules]


def test_data_flows_one_way_through_the_rooms():
    for file in FILES:
        room = file.relative_to(ROOT).parts[0]
        for module in imports(file):
            other = module.split(".")[0]
            if other in ROOMS:
                assert ROOMS.index(other) <= ROOMS.index(room), f"{file}: {module} is above {room}"


def test_the_solver_takes_from_the_recorder_what_reads_recordings():
    offered = face(ROOT / "recorder")
    taken = set()
    for file in sorted((ROOT / "solver").rglob("*.py")):
        for module in imports(file):
            if module.split(".")[0] in ("drivers", "recorder"):
                taken.add(module)
    assert taken <= {"recorder", "recorder.dataset"}, "neither a driver nor a terminal"
    names = {
        alias.name
        for file in sorted((ROOT / "solver").rglob("*.py"))
        for node in ast.walk(parsed(file))
        if isinstance(node, ast.ImportFrom) and re.fullmatch(r"\.*recorder", node.module or "")
        for alias in node.names
    }
    assert {offered[name] for name in names} <= READING


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda f: str(f.relative_to(ROOT)))
def test_a_face_offers_what_is_there(folder):
    """Each name is loaded from its file, and none has the name of a file of its folder."""
    names = face(folder)
    loaded = importlib.import_module(".".join(["mukca", *folder.relative_to(ROOT).parts]))
    assert sorted(names) == sorted(loaded.__all__)
    assert not set(names) & {file.stem for file in folder.glob("*.py")}
    assert all(getattr(loaded, name) is not None for name in names)


@pytest.mark.parametrize("module", CLOSURES)
def test_what_a_module_needs_only_falls(module):
    files = closure(module)
    size = len(files), sum(map(tokens, files))
    assert all(now <= most for now, most in zip(size, CLOSURES[module], strict=True)), size


def test_the_core_imports_nothing_of_the_rest_of_the_solver():
    core = [file for file in FILES if "identification" in file.parts]
    modules = {module for file in core for module in imports(file)}
    below = ("_faces", "errors", "recorder", "solver.identification")
    assert core and not [m for m in modules if not m.startswith(below)]


def test_a_calibration_needs_no_table_of_checks_and_studies():
    """They are handed in by ``pipeline.py``."""
    needed = closure("solver/calibration/robot_calibration.py")
    folders = {file.parent.name for file in needed}
    assert not folders & {"studies", "curves", "diagnostics", "design", "bases"}
    assert ROOT / "solver/calibration/tables.py" not in needed


def test_folders_come_in_by_each_others_faces():
    for file in FILES:
        for module in imports(file):
            target = ROOT.joinpath(*module.split("."))
            if module.split(".")[0] in ROOMS and not target.is_dir():
                assert target.parent == file.parent, f"{file}: {module} by its folder's face"


HUNG_ON = {
    "cameras": ["tool"],
    "emulators": ["robots"],
    "experiments": ["simulate"],
    "extract": ["extract"],
    "fleet": ["fleet"],
    "printables": ["preparation"],
}
"""Folders of the tools, and the modules of the verbs that alone import them."""


@pytest.mark.parametrize("folder", HUNG_ON)
def test_a_folder_that_hangs_on_its_verb_is_imported_by_that_alone(folder):
    verbs = ROOT / "tools" / "cli" / "commands"
    importers = {
        file
        for file in FILES
        if ROOT / "tools" / folder not in file.parents
        and any(module.split(".")[:2] == ["tools", folder] for module in imports(file))
    }
    assert importers == {verbs / f"{verb}.py" for verb in HUNG_ON[folder]}


def test_partial_fits_hang_on_their_verbs():
    """A camera's views and the guide to zeros take from them what they measure by."""
    importers = {
        file.relative_to(ROOT / "tools").parts[0]
        for file in FILES
        if file.is_relative_to(ROOT / "tools")
        and any(module.startswith("solver.partial") for module in imports(file))
    }
    assert importers == {"cli", "cameras", "recording"}


def test_what_a_module_imports_fits_a_glance_and_is_not_the_face_of_the_root():
    for file in FILES:
        assert len(set(imports(file))) <= 10 and "" not in imports(file), file


def test_folders_import_in_no_circle_and_the_page_shows_how():
    """``python docs/images/architecture.py`` draws both anew."""
    path = ROOT / "docs" / "images" / "architecture.py"
    spec = importlib.util.spec_from_file_location("architecture", path)
    drawing = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(drawing)
    graph = {folder: drawing.imports(folder) for folder in drawing.folders()}
    assert drawing.table(graph) in (ROOT / "docs" / "architecture.md").read_text()
    assert drawing.picture(graph) == (ROOT / "docs" / "images" / "architecture.svg").read_text()


def test_every_folder_with_code_is_shipped():
    shipped = set(PROJECT["tool"]["setuptools"]["packages"])
    folders = {".".join(["mukca", *file.relative_to(ROOT).parts[:-1]]) for file in FILES}
    assert folders | {"mukca"} == shipped


def test_the_root_holds_no_other_module():
    modules = {"__init__", "__main__", "_faces", "_version", "errors"}
    assert {file.stem for file in ROOT.glob("*.py")} == modules


def test_only_the_command_line_prints():
    for file in FILES:
        calls = [n for n in ast.walk(parsed(file)) if isinstance(n, ast.Call)]
        printing = [c for c in calls if isinstance(c.func, ast.Name) and c.func.id == "print"]
        assert not printing, file


def test_one_file_writes_to_the_terminal_and_cleans_what_it_writes():
    """The recorder's screen cleans its lines where it draws them."""
    writing = re.compile(r"std(out|err)\.write|(?<!Clean)Console\(stderr|from rich import print")
    writers = [str(file.relative_to(ROOT)) for file in FILES if writing.search(file.read_text())]
    assert writers == ["tools/cli/console.py"]


def test_numbers_with_a_sign_are_written_by_one_function():
    """What rounds to zero has no sign; see :func:`mukca.errors.fixed`."""
    for file in FILES:
        assert not re.findall(r"\{[^{}]*:[^{}]*\+[.\d]*[fd]\}", file.read_text()), file


def test_no_message_points_into_a_folder_that_is_not_installed():
    """The pages of docs/ come with the repository, not with the package."""
    for file in FILES:
        if "docs/" in file.read_text():
            values = [n.value for n in ast.walk(parsed(file)) if isinstance(n, ast.Constant)]
            shown = [v for v in values if isinstance(v, str) and "\n" not in v]
            assert not [text for text in shown if re.search(r"\bdocs/", text)], file


def test_constraints_pin_every_dependency():
    project = PROJECT["project"]
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pinned = {line.split("==")[0].lower().replace("_", "-") for line in lines if "==" in line}
    extras = project["optional-dependencies"].values()
    for requirement in [*project["dependencies"], *(r for extra in extras for r in extra)]:
        name = re.split("[^\\w.-]", requirement)[0]
        name = name.lower().replace("_", "-")
        assert name == "mukca" or name in pinned, requirement


def test_the_version_stands_in_one_place():
    version = mukca.__version__
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()
    assert version not in (ROOT / "pyproject.toml").read_text()
    assert not [file for file in FILES if f'"{version}"' in file.read_text()]


def test_a_release_has_one_version_one_date_and_one_tag():
    version = mukca.__version__
    assert re.fullmatch(r"\d+\.\d+\.\d+", version)
    citation = (ROOT / "CITATION.cff").read_text()
    (date,) = re.findall(r'^date-released: "(.*)"$', citation, re.M)
    assert f"\n## [{version}] - {date}\n" in (ROOT / "CHANGELOG.md").read_text()
    rules = (ROOT / "RELEASE.md").read_text()
    assert set(re.findall(r"`(?:git tag -s )?(v\S+?)`", rules)) == {"vX.Y.Z"}


def test_each_commit_runs_what_lint_runs():
    hooks = (ROOT / ".pre-commit-config.yaml").read_text()
    assert re.findall(r"entry: (.*)", hooks)[0] == "make lint"


def test_workflows_call_the_makefile_and_nothing_else():
    targets = re.findall(r"^(\w[\w-]*):", (ROOT / "Makefile").read_text(), re.M)
    for file in (ROOT / ".github" / "workflows").glob("*.yml"):
        runs = re.findall(r"- run: (.*)", file.read_text())
        assert runs and all(re.fullmatch(r"make (\w+)", run)[1] in targets for run in runs)


def test_the_page_for_readers_names_files_that_an_afternoon_is_enough_for():
    rows = re.findall(r"^\| \d+ \| `([\w/.]+)`", (ROOT / "docs" / "reading.md").read_text(), re.M)
    files = [ROOT / row for row in rows]
    assert len(files) == len(set(files)) == 25
    assert sum(map(tokens, files)) <= 25_000
    assert set(files[2:22]) <= closure("solver/identification/robot_fit.py")
