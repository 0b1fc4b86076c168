"""Placements, sockets and samples that are left out by hand, as in ``left:1:3,5-7``."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from ...errors import MukcaError
from ...recorder import Placement, Sample

_WORDS = re.compile(r"(?P<placement>.+?)(?::(?P<socket>\d+)(?::(?P<samples>\d[\d,-]*))?)?")
_RANGE = re.compile(r"(\d+)(?:-(\d+))?")
EXAMPLE = "write PLACEMENT, PLACEMENT:SOCKET or PLACEMENT:SOCKET:SAMPLES, as in left:1:3,5-7"


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

    @property
    def parts(self) -> "list[LeftOut]":
        """Each of the ranges of samples by itself."""
        return [replace(self, numbers=(ends,)) for ends in self.numbers] or [self]

    def names(self, placement: Placement) -> bool:
        """Tell whether it is of a placement, by its name, its folder's name or its path."""
        short = placement.name.split("/")[-1]
        return self.placement.rstrip("/") in (placement.name, short, str(placement.path or ""))

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
    numbers = list[tuple[int, int]]()
    for part in match["samples"].split(",") if match["samples"] else ():
        ends = _RANGE.fullmatch(part)
        if ends is None or int(ends[2] or ends[1]) < int(ends[1]):
            raise LeaveOutError(f"--leave-out {words}: samples {part!r}; {EXAMPLE}")
        numbers.append((int(ends[1]), int(ends[2] or ends[1])))
    socket = None if match["socket"] is None else int(match["socket"])
    return LeftOut(words, match["placement"], socket, tuple(numbers))


def without(placements: Sequence[Placement], left_out: Iterable[str]) -> list[Placement]:
    """Return placements without what is left out by hand; one that is empty by it is none."""
    remaining = list(placements)
    for item in map(parse_left_out, left_out):
        for i, placement in enumerate(remaining):
            if item.names(placement):
                samples = tuple(s for s in placement.samples if not item.holds(s))
                remaining[i] = replace(placement, samples=samples)
    pairs = zip(remaining, placements, strict=True)
    return [placement for placement, before in pairs if placement.samples or not before.samples]


def check_left_out(placements: Sequence[Placement], left_out: Iterable[str]) -> None:
    """Refuse, by a LeaveOutError, what names a placement, socket or sample that is not there."""
    for item in map(parse_left_out, left_out):
        matches = [placement for placement in placements if item.names(placement)]
        if not matches:
            name, _, numbers = item.placement.partition(":")
            if any(replace(item, placement=name).names(placement) for placement in placements):
                problem = f"{numbers!r} is no socket with samples of {name}; {EXAMPLE}"
                raise LeaveOutError(f"--leave-out {item.words}: {problem}")
            names = ", ".join(placement.name for placement in placements)
            raise LeaveOutError(f"--leave-out {item.words}: no such placement; there are: {names}")
        folders = {str(p.path.resolve() if p.path else p.name) for p in matches}
        if len(folders) > 1:
            names = ", ".join(sorted(folders))
            problem = f"{item.placement} is ambiguous; there are: {names}"
            raise LeaveOutError(f"--leave-out {item.words}: {problem}")
        for placement in matches:
            for part in item.parts:
                if not any(map(part.holds, placement.samples)):
                    numbers = "".join(f" {a}-{b}" if b > a else f" {a}" for a, b in part.numbers)
                    names = f"{placement.name} has no samples{numbers} in socket {item.socket}"
                    raise LeaveOutError(f"--leave-out {item.words}: {names}")
