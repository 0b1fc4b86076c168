"""The documents lead where they say, and none is left out of the site."""

import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = sorted((ROOT / "docs").glob("*.md"))


@pytest.mark.parametrize("page", [*PAGES, *ROOT.glob("*.md")], ids=lambda page: page.name)
def test_every_link_leads_to_a_file(page: Path) -> None:
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


def test_every_page_is_in_the_navigation() -> None:
    nav = (ROOT / "mkdocs.yml").read_text().split("\nnav:")[1]
    assert {page.name for page in PAGES} == set(re.findall(r"[\w-]+\.md", nav))


def test_every_verb_is_in_the_documents() -> None:
    from mukca.tools.cli import VERBS

    text = "\n".join(page.read_text() for page in [*PAGES, ROOT / "README.md"])
    assert [verb for verb in VERBS if f"mukca {verb}" not in text] == []


def test_every_command_in_the_documents_is_one() -> None:
    from mukca.tools.cli import VERBS, build_parser

    wrong: list[str] = []
    for page in [*PAGES, ROOT / "README.md"]:
        text = page.read_text().replace("\\\n", " ")
        for line in re.findall(rf"\bmukca (?:{'|'.join(VERBS)}) [^`|&\n]+$", text, re.M):
            words = shlex.split(line, comments=True)[1:]
            try:
                build_parser(words[0]).parse_args(words)
            except SystemExit:
                wrong.append(f"{page.name}: {line}")
    assert wrong == []
