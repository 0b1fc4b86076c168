"""Tables on a terminal and in a pipe."""

from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text


def table(
    title: str,
    heads: Sequence[str],
    rows: "Iterable[Sequence[str | Text]]",
    *,
    left: Collection[int] = (0,),
    bold: Collection[int] = (),
    no_wrap: bool = False,
) -> "Table":
    """Table with its columns of words to the left and its columns of figures to the right.

    Args:
        title: Line above it; may be empty.
        heads: Of the columns.
        rows: Cells: words taken as they are, or text with a style.
        left: Columns of words, which are folded where the terminal is narrow.
        bold: Rows that sum up others.
        no_wrap: Keep figures on one line.
    """
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    drawn = Table(
        box=SIMPLE_HEAD, title=Text(title) if title else None, title_justify="left",
        padding=(0, 1, 0, 0),
    )  # fmt: skip
    for column, head in enumerate(heads):
        if column in left:
            drawn.add_column(Text(head), overflow="fold", min_width=16 if no_wrap else None)
        else:
            drawn.add_column(Text(head), justify="right", no_wrap=no_wrap)
    for number, cells in enumerate(rows):
        shown = [cell if isinstance(cell, Text) else Text(cell) for cell in cells]
        drawn.add_row(*shown, style="bold" if number in bold else None)
    return drawn
