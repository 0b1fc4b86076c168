"""Verbs and formats of other packages stand beside mukca's own, and broken ones harm nothing."""

import json
import os
import socket
import subprocess
import sys
import threading

import pytest
from plugins import describe
from project import ROOT, tomllib

import mukca

EXAMPLE = ROOT / "examples" / "plugin"
CALIBRATION = ROOT / "tests" / "stored" / "1.0" / "calibrated" / "calibration.json"
PROJECT = tomllib.loads((EXAMPLE / "pyproject.toml").read_text())["project"]
BROKEN = {
    "raises": ("raise RuntimeError('no licence')", "no licence"),
    "leaves": ("raise SystemExit(3)", "SystemExit(3)"),
    "lacks": ("import a_package_that_is_nowhere", "a_package_that_is_nowhere"),
    "empty": ("", "has no attribute 'run'"),
}
"""The code of each, and what is told of it."""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Packages as pip would lay them out: the example, and broken ones that offer both."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "mukca_heron").symlink_to(EXAMPLE / "mukca_heron")
    describe(folder, PROJECT["name"], PROJECT["entry-points"], PROJECT["description"])
    for name, (code, _) in BROKEN.items():
        (folder / f"plugin_{name}.py").write_text(code)
        offered = {f"broken-{name}": f"plugin_{name}:run"}
        describe(folder, f"plugin-{name}", {"mukca.verbs": offered, "mukca.exports": offered})
    (folder / "plugin_taken.py").write_text("def run():\n    raise AssertionError\n")
    taken = {
        "mukca.verbs": {"info": "plugin_taken:run"},
        "mukca.exports": {"mdh": "plugin_taken:run"},
    }
    describe(folder, "plugin-taken", taken)
    return folder


@pytest.fixture
def typed(site):
    """Run `mukca` with words where the packages are installed: status, output, error."""

    def run(*words, **variables):
        path = os.pathsep.join([str(site), os.environ.get("PYTHONPATH", "")])
        environment = {
            **os.environ,
            "PYTHONPATH": path,
            "PYTHONDONTWRITEBYTECODE": "1",
            **variables,
        }
        done = subprocess.run(
            [sys.executable, "-m", "mukca", *map(str, words)],
            env=environment, capture_output=True, text=True, check=False,
        )  # fmt: skip
        return done.returncode, done.stdout, done.stderr

    return run


def test_help_lists_verbs_and_formats_by_the_description_of_their_package(typed):
    status, out, err = typed("--help")
    assert (status, err) == (0, "")
    others = out.partition("of other packages:\n")[2]
    assert "  heron-torques the Heron, an arm that does not exist\n" in others
    assert "  broken-raises plug-in\n" in others and "  info " not in others
    assert "  info         show what is in recordings\n" in out
    status, out, err = typed("export", "--help")
    assert (status, err) == (0, "")
    assert "  heron       the Heron, an arm that does not exist\n" in out
    assert out.count("  mdh ") == 1


def test_a_verb_has_its_help_its_options_and_its_completion(typed, tmp_path):
    status, out, _ = typed("heron-torques", "--help")
    assert status == 0 and "address of the Heron, HOST[:PORT]" in out
    assert "  mukca heron-torques 127.0.0.1\n" in out
    pytest.importorskip("argcomplete")
    words = tmp_path / "words"
    shell = {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": "\n",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(words),
    }
    for line, expected in ("mukca heron", "heron-torques "), ("mukca heron-torques --j", "--json "):
        typed(**shell, COMP_LINE=line, COMP_POINT=str(len(line)))
        assert words.read_text() == expected


def test_a_verb_runs_as_mukcas_own(typed):
    sys.path.insert(0, str(EXAMPLE))
    try:
        from mukca_heron.simulator import serve
    finally:
        sys.path.remove(str(EXAMPLE))
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=serve, args=(server,), daemon=True).start()
        address = f"127.0.0.1:{server.getsockname()[1]}"
        status, out, err = typed("heron-torques", address, "--json")
    assert (status, json.loads(out)) == (0, {"torques": [0.0, 2.0, 4.0, 6.0]}), err
    status, out, err = typed("heron-torques", "127.0.0.1:9")
    assert (status, out) == (2, "")
    assert (
        err
        == "mukca heron-torques: 127.0.0.1:9 refused the connection: is the Heron switched on?\n"
    )


def test_a_format_writes_the_calibrated_origins(typed, tmp_path):
    file = tmp_path / "arm.heron"
    status, _, err = typed("export", CALIBRATION, "--to", "heron", "--out", file)
    assert status == 0, err
    rows = [line.split() for line in file.read_text().splitlines() if not line.startswith("#")]
    calibrated = mukca.load_calibration(CALIBRATION).calibrated
    assert [[float(x) for x in row[1:]] for row in rows] == calibrated.origins.tolist()
    status, _, err = typed("export", CALIBRATION, "--to", "heron", "--out", "x", "--like", "y")
    assert status == 2 and "not for heron" in err


@pytest.mark.parametrize("name", BROKEN)
def test_what_cannot_be_imported_is_one_line_and_harms_nothing(typed, name):
    verb = f"broken-{name}"
    export = ("export", CALIBRATION, "--to", verb, "--out", "x")
    for words, kind in ((verb, "--help"), "verb"), (export, "format"):
        status, out, err = typed(*words)
        assert (status, out, err.count("\n")) == (2, "", 1), err
        assert f"{kind} {verb!r} of plugin-{name} 0.1" in err and BROKEN[name][1] in err


def test_no_package_takes_the_name_of_a_verb_or_a_format(typed, tmp_path):
    assert typed("info", "--help")[0] == 0
    out = tmp_path / "arm.csv"
    assert typed("export", CALIBRATION, "--to", "mdh", "--out", out)[0] == 0 and out.is_file()
