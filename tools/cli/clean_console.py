"""Console of rich to which no text of a file gives a command."""

from collections.abc import Iterable

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from ...errors import cleaned


class CleanConsole(Console):
    """A console whose text is cleaned; styles, and what moves the cursor, are those of mukca."""

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """Yield the segments of whatever is printed."""
        for text, style, control in super().render(renderable, options):
            yield Segment(text if control else cleaned(text), style, control)
