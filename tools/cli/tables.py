"""Tables for people: drawn where they fit, else one row after the other, in words."""

import re
import textwrap
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult
    from rich.table import Table
    from rich.text import Text

NAME = 16
"""Letters of a name that stand on a line at least; longer names are folded."""
_COMMAND = re.compile(r"(^|[:$] )mukca ")


def wrapped(text: str, columns: int) -> list[str]:
    """Return lines of a text, broken between words; a line with a command stays whole, to copy."""
    lines: list[str] = []
    for line in text.split("\n"):
        if len(line) <= columns or _COMMAND.search(line):
            lines.append(line)
            continue
        indent = line[: len(line) - len(line.lstrip())]
        lines += textwrap.wrap(
            line,
            columns,
            subsequent_indent=indent,
            break_long_words=False,
            break_on_hyphens=False,
        )
    return lines


def in_words(heads: Sequence[str], cells: Sequence[str]) -> str:
    """Return a row whose cells follow their heads, as in ``left: mean 0.12, largest 0.31``.

    A single cell is a remark, and a dash stands for nothing.
    """
    first, *others = cells
    if not others:
        return first
    facts: list[str] = []
    for head, cell in zip(heads[1:], others, strict=True):
        facts += [f"{head} {cell}".strip()] if cell.strip("-") else []
    return f"{first}: {', '.join(facts)}"


@dataclass(frozen=True)
class FittingTable:
    """Table that a rich console draws where its figures fit, and else tells in words."""

    title: str
    heads: Sequence[str]
    rows: "Sequence[Sequence[str | Text]]"
    left_columns: Collection[int] = (0,)
    """Columns of words, to the left and folded where narrow; figures are to the right."""
    bold: Collection[int] = ()
    """Rows that sum up others."""
    no_wrap: bool = False
    """True to keep the figures of a cell on one line."""

    @property
    def least_width(self) -> int:
        """Columns of a terminal on which no figure is cut."""
        width = 1  # of both edges, less what follows no last column
        for column, head in enumerate(self.heads):
            cells = [str(row[column]) for row in self.rows]
            words = [word for cell in cells for word in cell.split()] + head.split()
            if column in self.left_columns:
                longest = NAME if self.no_wrap else min(NAME, _longest(words))
            else:
                longest = _longest([*cells, head] if self.no_wrap else words)
            width += longest + 2
        return width

    def __rich_console__(
        self, console: "Console", options: "ConsoleOptions"
    ) -> "RenderResult":
        """Yield the table, or lines in its place."""
        from rich.text import Text

        if self.least_width <= options.max_width:
            yield self._drawn()
            return
        texts = [self.title] if self.title else []
        for row in self.rows:
            texts.append(in_words(self.heads, [str(cell) for cell in row]))
        for text in texts:
            yield Text(text, no_wrap=False, overflow="fold")

    def _drawn(self) -> "Table":
        from rich.box import SIMPLE_HEAD
        from rich.table import Table
        from rich.text import Text

        drawn = Table(
            box=SIMPLE_HEAD,
            title=Text(self.title) if self.title else None,
            title_justify="left",
            padding=(0, 1, 0, 0),
        )
        for column, head in enumerate(self.heads):
            if column in self.left_columns:
                name_width = NAME if self.no_wrap else None
                drawn.add_column(Text(head), overflow="fold", min_width=name_width)
            else:
                drawn.add_column(Text(head), justify="right", no_wrap=self.no_wrap)
        for number, row in enumerate(self.rows):
            cells = [Text(cell) if isinstance(cell, str) else cell for cell in row]
            drawn.add_row(*cells, style="bold" if number in self.bold else None)
        return drawn


def _longest(texts: Iterable[str]) -> int:
    return max(map(len, texts), default=0)
