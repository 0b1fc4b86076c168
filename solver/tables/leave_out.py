"""Placements, sockets and samples that are left out by hand, as in ``left:1:3,5-7``."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from ...errors import MukcaError
from ...recorder import Placement, Sample
from ..identification.data import is_called

_WORDS = re.compile(r"(.+?)(?::(\d+)(?::(\d[\d,-]*))?)?")
"""Placement, socket and samples."""
_RANGE = re.compile(r"(\d+)(?:-(\d+))?")
EXAMPLE = (
    "write PLACEMENT, PLACEMENT:SOCKET or PLACEMENT:SOCKET:SAMPLES, as in left:1:3,5-7"
)


class LeaveOutError(MukcaError):
    """An item to leave out is not there, or nothing would be left."""


@dataclass(frozen=True)
class LeftOut:
    """A placement, a socket of it, or some of that socket's samples."""

    words: str
    """As it was given."""
    placement: str
    socket: int | None = None
    numbers: tuple[tuple[int, int], ...] = ()
    """First and last of samples, as the screen and ``check`` number them; none for all."""

    def refusal(self, problem: str) -> LeaveOutError:
        """Return the error that says why it cannot be left out."""
        return LeaveOutError(f"--leave-out {self.words}: {problem}")

    def names(self, placement: Placement) -> bool:
        """Tell whether it is of a placement, by its name, its folder's name or its path."""
        name = self.placement.rstrip("/")
        return is_called(placement.name, name) or name == str(placement.path or "")

    def holds(self, sample: Sample) -> bool:
        """Tell whether it holds a sample of its placement."""
        if self.socket is None:
            return True
        number = sample.number or sample.place
        listed = any(first <= number <= last for first, last in self.numbers)
        return sample.socket == self.socket and (listed or not self.numbers)


def parse_left_out(words: str) -> LeftOut:
    """Return what words such as ``left:1:3,5-7`` stand for; raises LeaveOutError."""
    match = _WORDS.fullmatch(words)
    if match is None:
        raise LeaveOutError(f"--leave-out {words}: {EXAMPLE}")
    placement, socket, samples = match.groups()
    numbers: list[tuple[int, int]] = []
    for part in samples.split(",") if samples else ():
        ends = _RANGE.fullmatch(part)
        first = int(ends[1]) if ends else 1
        last = int(ends[2] or ends[1]) if ends else 0
        if last < first:
            raise LeaveOutError(f"--leave-out {words}: samples {part!r}; {EXAMPLE}")
        numbers.append((first, last))
    number = None if socket is None else int(socket)
    return LeftOut(words, placement, number, tuple(numbers))


def without(
    placements: Sequence[Placement], left_out: Iterable[str]
) -> list[Placement]:
    """Return placements without what is left out by hand; one that is empty by it is none."""
    items = [parse_left_out(words) for words in left_out]
    remaining: list[Placement] = []
    for placement in placements:
        of_placement = [item for item in items if item.names(placement)]
        samples = tuple(
            s
            for s in placement.samples
            if not any(item.holds(s) for item in of_placement)
        )
        if samples or not placement.samples:
            remaining.append(replace(placement, samples=samples))
    return remaining


def check_left_out(placements: Sequence[Placement], left_out: Iterable[str]) -> None:
    """Refuse, by a LeaveOutError, what names a placement, socket or sample that is not there."""
    for item in map(parse_left_out, left_out):
        matches = [placement for placement in placements if item.names(placement)]
        if not matches:
            name, _, numbers = item.placement.partition(":")
            if any(
                replace(item, placement=name).names(placement)
                for placement in placements
            ):
                raise item.refusal(
                    f"{numbers!r} is no socket with samples of {name}; {EXAMPLE}"
                )
            names = ", ".join(placement.name for placement in placements)
            raise item.refusal(f"no such placement; there are: {names}")
        folders = {str(p.path.resolve() if p.path else p.name) for p in matches}
        if len(folders) > 1:
            names = ", ".join(sorted(folders))
            raise item.refusal(f"{item.placement} is ambiguous; there are: {names}")
        for placement in matches:
            for ends in item.numbers or [()]:
                part = replace(item, numbers=(ends,) if ends else ())
                if not any(map(part.holds, placement.samples)):
                    numbers = "-".join(map(str, dict.fromkeys(ends)))
                    samples = f"samples {numbers}".rstrip()
                    raise item.refusal(
                        f"{placement.name} has no {samples} in socket {item.socket}"
                    )
