"""The help of the verbs: each option has a text, and each text an option."""

import io
from contextlib import redirect_stdout, suppress
from pathlib import Path

import mukca.tools.cli
from mukca.tools.cli import VERBS, main

TEXTS = Path(mukca.tools.cli.__file__).with_name("options.txt").read_text().split("\n")


def test_each_text_is_of_an_option_that_there_is():
    with redirect_stdout(io.StringIO()) as shown:
        for words in (
            *([verb] for verb in VERBS),
            ["simulate", "insertion"],
            ["simulate", "drawing"],
        ):
            with suppress(SystemExit):
                main([*words, "--help"])
    heads = [line.partition(":")[0].split() for line in TEXTS if line and line[0] not in " #["]
    lost = [
        name
        for name, *metavar in heads
        if f"--{name.replace('_', '-')}" not in shown.getvalue()
        and " ".join(metavar) not in shown.getvalue()
    ]
    assert len(heads) > 150 and lost == []
