"""The documents lead where they say, and none is left out of the site."""

import importlib.util
import inspect
import itertools
import json
import math
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from altered import HOLES

import mukca
from mukca.solver.diagnostics import CAUSES

ROOT = Path(__file__).parents[1]
PAGES = sorted((ROOT / "docs").glob("*.md"))


@pytest.mark.parametrize("page", [*PAGES, *ROOT.glob("*.md")], ids=lambda page: page.name)
def test_every_link_leads_to_a_file(page):
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.M | re.S)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        path, _, anchor = target.partition("#")
        if "://" in target or target.startswith("mailto:"):
            continue
        file = page.parent / path if path else page
        assert file.exists(), f"{page.name}: {target}"
        if anchor and file.suffix == ".md":
            headings = re.findall(r"^#+ (.*)$", file.read_text(), re.M)
            slugs = {re.sub(r"[^\w -]", "", h).strip().lower().replace(" ", "-") for h in headings}
            assert anchor in slugs, f"{page.name}: {target}"


REFERENCES = {"api", "benchmarks", "glossary", "messages", "model"}
"""Pages to look something up in; nobody reads them from top to bottom."""
MOST = 1500
"""Words of any other page, tables and code included."""


@pytest.mark.parametrize(
    "page", [p for p in PAGES if p.stem not in REFERENCES], ids=lambda page: page.stem
)
def test_a_page_is_read_in_some_minutes(page):
    assert len(page.read_text().split()) <= MOST


SHOWN = re.compile(r"^ *```.*?^ *```|^[$]{2}.*?[$]{2}$|^(?:    |#|[|]|!\[|<)[^\n]*", re.M | re.S)
"""What a page shows and does not say: code, formulas, titles, tables, pictures."""
LONGEST = 30
"""Words of a sentence of help, or of a message."""


def sentences(text):
    """The sentences of a text, as lists of words; code counts as a word."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", SHOWN.sub("", text))
    text = re.sub(r"`[^`]*`", "x", text)
    for block in re.split(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.) )", text):
        for sentence in re.split(r"(?<=[.!?])\s+", block):
            words = [word for word in sentence.split() if re.search(r"\w", word)]
            if len(words) > 2:
                yield words


@pytest.mark.parametrize(
    "page",
    [page for page in [*PAGES, *(ROOT / "docs/causes").glob("*.md"), *ROOT.glob("*.md")]
     if page.name not in ("benchmarks.md", "CHANGELOG.md")],
    ids=lambda page: page.stem,
)  # fmt: skip
def test_a_page_has_20_words_a_sentence_on_average_and_40_at_most(page):
    said = list(sentences(page.read_text()))
    assert not said or sum(map(len, said)) / len(said) <= 20
    assert [" ".join(words) for words in said if len(words) > 40] == []


def test_no_sentence_of_a_caption_has_over_30_words():
    """Words under pictures, and those of the report's plots with what is put in left out."""
    pictures = [page.read_text() for page in [*PAGES, *ROOT.glob("*.md")]]
    said = [c for text in pictures for c in re.findall(r'!\[([^\]]*)\]|alt="([^"]*)"', text)]
    captions = (ROOT / "tools/report/templates/texts.txt.j2").read_text()
    prose = re.sub(r"^- .*$|{%.*?%}|{#.*?#}", "", captions, flags=re.M | re.S)
    said += re.findall(r"^.+$", re.sub(r"{{.*?}}", "x", prose), re.M)
    said = ["".join(caption) for caption in said]
    long = [" ".join(words) for caption in said for words in sentences(caption)]
    assert len(said) > 40 and not [text for text in long if len(text.split()) > LONGEST]


def test_no_sentence_of_help_has_over_30_words():
    from mukca.tools.cli import VERBS, build_parser

    for verb in VERBS:
        helps = [action.help or "" for action in build_parser(verb)._actions]
        long = [" ".join(words) for text in helps for words in sentences(text)]
        assert not [text for text in long if len(text.split()) > LONGEST], verb
    folder = ROOT / "tools/cli/commands"
    pages = re.split(r"^# .*$", (folder / "verbs.txt").read_text(), flags=re.M)
    prose = [re.sub(r"^(?:  |\w+:).*$", "", page, flags=re.M) for page in pages]
    said = [words for page in prose for words in sentences(page)]
    assert not [" ".join(words) for words in said if len(words) > LONGEST]


def test_no_sentence_of_a_message_has_over_30_words():
    pytest.importorskip("latex2mathml", reason="the extra docs is not installed")
    hooks = script_of(ROOT / "docs/_site/hooks.py")
    messages = list(hooks._messages())
    assert any("it adds little: guide the arm" in line for line in messages)  # by a variable
    said = [words for line in messages for words in sentences(line.lstrip("- "))]
    assert len(said) > 500
    assert not [" ".join(words) for words in said if len(words) > LONGEST]


def script_of(path):
    """A script, as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return script


def test_every_page_is_in_the_navigation():
    nav = (ROOT / "mkdocs.yml").read_text().split("\nnav:")[1]
    assert {page.name for page in PAGES} == set(re.findall(r"[\w-]+\.md", nav))


@pytest.mark.slow
def test_every_cause_has_the_page_that_the_program_names(tmp_path):
    copy = shutil.copytree(ROOT / "docs/causes", tmp_path / "causes")
    subprocess.run([sys.executable, str(copy / "pages.py")], check=True)
    for page in copy.glob("*.md"):
        assert page.read_text() == (ROOT / "docs/causes" / page.name).read_text(), page.name
    names = {cause.name for cause in CAUSES}
    assert names | {"index"} == {page.stem for page in (ROOT / "docs/causes").glob("*.md")}


OWN_TABLE = re.compile(r"mukca solve t\.csv --robot (\w+) (--columns 'q=A1\.\.(\d)[^\n]*) --out")


@pytest.mark.parametrize("page", [p for p in PAGES if "## Proven on" in p.read_text()])
def test_the_page_of_an_arm_reads_a_table_of_ones_own(page, command, tmp_path, monkeypatch):
    """Its command, and the same as the refusal of that table words it."""
    monkeypatch.chdir(tmp_path)
    name, columns, count = OWN_TABLE.findall(page.read_text())[0]
    robot = mukca.load_robot(name)
    truth, (placement,) = mukca.simulate_recordings(robot, 1, samples=10, seed=1)
    heads = [*(f"A{i + 1}" for i in range(int(count))), *"XYZ"]
    points = 1e3 * truth.ball(placement.positions) + [6000, 0, 0]  # a frame of its own
    rows = np.hstack([np.degrees(placement.positions), points])
    np.savetxt("t.csv", rows, delimiter=",", header=",".join(heads), comments="")
    status, _, refusal = command("solve", "t.csv", "--robot", name, "--out", "calibrated")
    told = re.findall(r"'([^']*)'", refusal)
    assert status == 2 and len(told) == 4, refusal
    assert not Path("calibrated").exists()  # where the second command writes
    for out, own in (("page", shlex.split(columns)[1:]), ("refusal", told)):
        assert (
            command("convert", "t.csv", "--to", "points", "--out", out, "--columns", *own)[0] == 0
        )
        (read,) = mukca.read_placements(out)
        assert np.allclose(read.positions, placement.positions)
        assert np.allclose([1e3 * np.array(s.point) for s in read.samples], points)


def test_the_page_of_alarms_has_the_key_that_cures_each():
    from mukca.recorder.session import CURES, KEYS

    page = (ROOT / "docs/alarms.md").read_text()
    rows = re.findall(r"^\| ([A-Z ?]+) \|.*\| (.*) \|$", page, re.M)
    alarms = json.loads((ROOT / "tools/recording/alarms.json").read_text()).values()
    cures = {alarm["words"]: (*CURES[alarm["cause"]], "keep")[0] for alarm in alarms}
    of_action = {action: key for key, action in KEYS.items()}
    told = {words: f"`{of_action[cure]}`" for words, cure in cures.items()}
    wrong = {words: key for words, key in told.items() if key not in dict(rows)[words]}
    assert wrong == {}


def test_every_verb_is_in_the_documents():
    from mukca.tools.cli import VERBS

    text = "\n".join(page.read_text() for page in [*PAGES, ROOT / "README.md"])
    assert [verb for verb in VERBS if f"mukca {verb}" not in text] == []


def test_the_skill_file_has_the_verbs_and_the_keys_that_there_are():
    from mukca.solver.assessment import Verdict
    from mukca.tools.cli import VERBS

    text = (ROOT / "skills/mukca/SKILL.md").read_text()
    table = text.partition("## Verbs")[2].partition("\n\n`mukca VERB")[0]
    verbs = re.findall(r"`([\w-]+)`", table)
    assert set(VERBS) - set(verbs) == {"simulate", "emulate"} and set(verbs) <= set(VERBS)
    assert set(re.findall(r"verdict\.(\w+)", text)) <= set(Verdict.__struct_fields__)


def test_the_page_for_programs_leads_to_pages():
    links = re.findall(r"\]\((.*?)\)", (ROOT / "docs/llms.txt").read_text())
    assert links and [link for link in links if not (ROOT / "docs" / link).exists()] == []


@pytest.mark.slow
def test_every_command_in_the_documents_is_one():
    from mukca.tools.cli import VERBS, build_parser

    wrong = []
    pages = [page for page in PAGES if page.name != "benchmarks.md"]  # that shows what was printed
    for page in [*pages, ROOT / "README.md"]:
        text = page.read_text().replace("\\\n", " ")
        for line in re.findall(rf"\bmukca (?:{'|'.join(VERBS)}) [^`|&\n]+$", text, re.M):
            words = shlex.split(line, comments=True)[1:]
            try:
                build_parser(words[0]).parse_args(words)
            except mukca.MukcaError:
                wrong.append(f"{page.name}: {line}")
    assert wrong == []


@pytest.mark.slow
def test_the_readme_says_how_far_distances_between_bases_are_off(recordings):
    robot = mukca.load_robot(recordings / "panda_3/nominal.urdf")
    placements = mukca.read_placements(recordings / "panda_3")
    train = [p for p in placements if p.path and p.path.name == "frontcenter"]
    ball_alone = {"method": "paper", "free": [f"{robot.ball_joint.name}.xyz"]}
    refitted = mukca.calibrate(robot, train, **ball_alone).calibrated
    calibrated = mukca.calibrate(robot, train).calibrated

    def off(ball):
        seats = {
            p.path.name: [ball(p.positions)[p.sockets == k].mean(axis=0) for k in (0, 1)]
            for p in placements
            if p.path
        }
        return [
            abs(1e3 * float(np.linalg.norm(a - b)) - math.dist(HOLES[here], HOLES[there]))
            for here, there in itertools.combinations(HOLES, 2)
            for a, b in zip(seats[here], seats[there], strict=True)
        ]

    before, after = off(refitted.ball), off(calibrated.geometric_ball)
    text = " ".join((ROOT / "README.md").read_text().split())
    assert f"by {np.mean(before):.2f} mm on average before ({max(before):.1f} at most)" in text
    assert f"wrong by {np.mean(after):.2f} mm ({max(after):.2f})" in text


@pytest.mark.slow
def test_figures_of_the_tutorials_arm_are_those_of_its_commands(
    recordings, command, tmp_path, monkeypatch
):
    """Those printed below a command, and those of the same arm on other pages."""
    monkeypatch.chdir(tmp_path)
    Path("recordings").symlink_to(recordings / "panda_3")
    page = (ROOT / "docs/tutorial.md").read_text().partition("## 5")[0]
    blocks = re.findall(r"^```\n(.*?)^```", page, re.M | re.S)
    commands = [block for block in blocks if block.startswith("mukca")]
    solve = next(words for words in commands if " solve " in words)
    export = "mukca export calibrated/calibration.json --to mdh --out arm.csv"
    told = ""
    for words in (*commands, f"{solve} --details --force", export):
        _, out, err = command(*shlex.split(words)[1:])
        told += out + err
        assert words != solve or len((out + err).splitlines()) <= 24  # one screen
    shown = [block for block in blocks if block not in commands]
    shown += re.findall(
        r"^    With the new URDF.*?\n\n", (ROOT / "README.md").read_text(), re.M | re.S
    )
    shown += re.findall(
        r"^```text\nWith the new URDF.*?^```", (ROOT / "docs/report.md").read_text(), re.M | re.S
    )
    shown += re.findall(rf"^{export}(.*?)^```", (ROOT / "docs/use.md").read_text(), re.M | re.S)
    shown = [text for text in shown if re.search(r"\d\.\d", text)]
    assert len(shown) == 6
    for text in shown:
        figures = re.findall(r"\d+\.\d+", text)
        assert set(figures) <= set(re.findall(r"\d+\.\d+", told)), text


def test_figures_are_those_of_the_benchmarks():
    """After ``python benchmarks/page.py --measure ...`` the other pages take what it found."""
    script = script_of(ROOT / "benchmarks" / "page.py")
    figures = json.loads((ROOT / "docs" / "benchmarks.json").read_text())
    assert script.page(figures) == (ROOT / "docs" / "benchmarks.md").read_text()
    rows = script.table_rows(figures["accuracy"]["found"])
    nominal, refitted, urdf, full = script.instrument(figures)
    readme, text, apart = (
        " ".join((ROOT / page).read_text().split())
        for page in ("README.md", "docs/accuracy.md", "docs/apart.md")
    )
    assert f"{refitted} mm before, **{full} mm** with corrected joints" in readme
    before, _, urdf_alone, full_alone, _ = rows[0].split(" | ")[1:]
    means = [before, *(cell.split()[0] for cell in (urdf_alone, full_alone))]
    assert " ".join(means) in apart
    assert [row for row in rows if row not in text] == []
    arms = figures["arms"]["found"].splitlines()[2:]
    assert len(arms) == 4 and [row for row in arms if row not in text] == []
    assert f"{nominal} mm nominal" in text and f"**{full} mm**" in text
    assert f"{refitted} mm with the reflector's place refitted, {urdf} mm by the URDF alone" in text


@pytest.mark.slow
def test_the_page_of_python_and_the_examples_are_typed(tmp_path):
    pytest.importorskip("pyright", reason="the extra lint is not installed")
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/python.md").read_text(), re.S)
    (tmp_path / "page.py").write_text("".join(["# pyright: strict\n", *blocks]))
    for name in ("calibrate_from_csv", "monte_carlo", "own_urdf", "stream_arm"):
        text = (ROOT / "examples" / f"{name}.py").read_text()
        (tmp_path / f"{name}.py").write_text(f"# pyright: strict\n{text}")
    (tmp_path / "mukca").symlink_to(ROOT)  # whatever the clone is called
    settings = {"reportUnusedExpression": "none"}
    (tmp_path / "pyrightconfig.json").write_text(json.dumps(settings))
    words = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable]
    words += [str(file) for file in tmp_path.glob("*.py")]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert len(blocks) > 4 and done.returncode == 0, done.stdout


def test_what_a_public_function_returns_is_public():
    names = set(mukca.__all__)
    for name in names:
        value = getattr(mukca, name)
        if inspect.isfunction(value):
            said = str(inspect.signature(value).return_annotation)
            assert set(re.findall(r"mukca\.[\w.]+\.(\w+)", said)) <= names, said
