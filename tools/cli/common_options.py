"""Options that several verbs have: JSON, the payload, and where results go."""

from pathlib import Path

from ...solver import results
from .arguments import NOT_NEGATIVE, Options, option


class JsonOption(Options, group="output"):
    """Option of each verb that scripts read."""

    json: bool = option(False, "print one JSON object, SI units")


class PayloadOptions(Options):
    """Options of the payload."""

    payload: float | None = option(
        None,
        "mass on the flange in kilograms (default: as while recording)",
        "KG",
        between=NOT_NEGATIVE,
    )
    payload_at: tuple[float, float, float] = option(
        (0, 0, 0),
        "with --payload: the centre of that mass in the flange's frame, in metres",
        ("X", "Y", "Z"),
        needs="payload",
    )

    @property
    def carried(self) -> tuple[float, tuple[float, float, float]] | None:
        """Mass [kg] and centre [m] of the payload; None for that of the recordings."""
        return None if self.payload is None else (self.payload, self.payload_at)


class OutputOptions(JsonOption, group="output"):
    """Options of a verb that writes files."""

    out: Path | None = option(None, "write the results to this folder", "DIR")
    force: bool = option(False, "overwrite what is there", needs="out")

    def check_out(self) -> None:
        """Refuse a folder whose results would be overwritten, before any work."""
        if self.out is not None:
            results.refuse_existing(self.out, force=self.force)


class DetailsOptions(OutputOptions):
    """Options of a verb whose screen is its answer alone."""

    details: bool = option(False, "show all figures below the answer, too")
