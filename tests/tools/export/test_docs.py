"""Commands in the documents on exports and logs are commands of this version."""

import re
import shlex
from pathlib import Path

import pytest

from mukca.tools.cli import build_parser

DOCS = Path(__file__).parents[3] / "docs"


@pytest.mark.parametrize("page", ["use.md", "gripper.md", "extract.md"])
def test_every_command_is_understood(page: str) -> None:
    text = (DOCS / page).read_text().replace("\\\n", " ")
    lines = re.findall(r"^    mukca (.*)$", text, re.M)
    assert lines
    for line in lines:
        words = shlex.split(line)
        build_parser(words[0]).parse_args(words)


def test_the_table_answers_for_ten_programs() -> None:
    text = (DOCS / "use.md").read_text()
    table = text.split("| program | what to load |")[1].split("\n\n")[0]
    assert table.count("\n| ") >= 10
