"""Suspected flaws in words, as ``base@6:5mm`` or ``sag 3mm``: a cause, its place, and its size.

The words are those of the causes, and of the simulated arm's faults.
"""

import difflib
import re
from dataclasses import dataclass, replace

from ....errors import MukcaError
from .kinds import UNITS, Block, Kind, Parameters
from .scene import Scene
from .table import SIMULATED

FLAWS: dict[str, tuple[Kind, ...]] = {
    word: tuple(kind for kind in SIMULATED if word in (kind.fault, kind.name))
    for word in sorted({kind.fault or kind.name for kind in SIMULATED})
}
"""Kinds of explanations by the word of their flaw."""
_SIZE = re.compile(
    r"(?<![\d.,])([-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:e[-+]?\d+)?)\s*(mm|deg|%)\s*$"
)
_OTHER_SIZE = re.compile(r"[-+]?[\d.,]*(?:[uµμcm]?m|in|°|deg|degrees|[uµμm]?rad|%)?")
"""A number or a unit that is no size, unless it is a name."""
_SAMPLE = re.compile(r"@(\d+)(?:\+\d+)?$")


class FlawError(MukcaError):
    """No flaw is called so, or none such can be in these recordings."""


@dataclass(frozen=True)
class Flaw:
    """A suspected flaw: what it may be, where it begins, and how large it is."""

    text: str
    kinds: tuple[Kind, ...]
    names: tuple[str, ...] = ()
    """Of a joint or a placement, if any was told."""
    sample: int | None = None
    """Number of the first sample that has it."""
    size: float | None = None
    """[m, rad, share]; None for the size that fits best."""

    @classmethod
    def parse(cls, text: str) -> "Flaw":
        """Return the flaw that ``KIND [NAME] [@SAMPLE] [SIZE]`` names, blanks or colons between.

        Raises:
            FlawError: It names none.
        """
        match = _SIZE.search(text)
        before_size = text[: match.start()] if match else text
        word, *names = _words(before_size) or [""]
        kinds = FLAWS.get(word) or tuple(
            kind for kind in SIMULATED if kind.name == word
        )
        if not kinds:
            raise FlawError(
                f"fault {text!r}: no fault is called {word!r}{_words_like(word)}"
            )
        unit = match[2] if match else None
        kinds_of_unit = tuple(kind for kind in kinds if unit in (None, kind.unit))
        size = None
        if match:
            digits = match[1].replace(",", ".")
            size = float(digits) / UNITS[match[2]]
        if not kinds_of_unit or (size is not None and size <= 0):
            raise FlawError(f"fault {text!r}: {_size_expected(word, kinds[0].unit)}")
        marks = [_SAMPLE.match(name) for name in names]
        samples = [int(mark[1]) for mark in marks if mark]
        others = tuple(name for name in names if not _SAMPLE.match(name))
        return cls(
            text,
            kinds_of_unit,
            others,
            samples[0] if samples else None,
            size,
        )

    @property
    def unit(self) -> str:
        """Unit in which its size is told."""
        return self.kinds[0].unit or ""

    def of_size(self, size: float) -> "Flaw":
        """Return it with a size [m, rad, share]."""
        return replace(self, size=size)

    def possible(self, scene: Scene) -> tuple[Kind, ...]:
        """Return its kinds with the candidates that it may be.

        Raises:
            FlawError: There are none in this scene, or none that can be told.
        """
        if scene.zeros and all(kind.rigid for kind in self.kinds):
            reason = "play, and zeros that are off by degrees, look the same; leave out --zeros"
            raise FlawError(f"fault {self.text!r}: {reason}")
        kinds: list[Kind] = []
        of_all = not self.names and self.sample is None
        for kind in self.kinds:
            blocks = [self._named(block) for block in kind.blocks(scene)]
            blocks = [block for block in blocks if block.parameters]
            if blocks:
                kinds.append(kind.only(blocks))
            elif kind.noise is not None and of_all:
                kinds.append(kind)
        if not kinds:
            raise FlawError(f"fault {self.text!r}: {self._impossible(scene)}")
        return tuple(kinds)

    def _impossible(self, scene: Scene) -> str:
        """Return in words why no kind of it is in a scene."""
        word, kind = _words(self.text)[0], self.kinds[0]
        joints = scene.robot.joint_names
        placements = [m.name for m in scene.measurements]
        folders = [name.rpartition("/")[2] for name in placements]
        strange = {*self.names}.difference(placements, folders)
        is_other_size = any(map(_OTHER_SIZE.fullmatch, strange))
        if is_other_size:
            return _size_expected(word, kind.unit)
        marks = [f"@{self.sample}"] if self.sample is not None else []
        names = " ".join((*self.names, *marks))
        if names and kind.noise:
            return f"{word!r} is of all samples; leave out {names!r}"
        reason = "can have none"
        if names:
            reason = f"can have none of {names!r}"
        return (
            f"these recordings {reason}; the joints are {', '.join(joints)}, "
            f"the placements {', '.join(placements)}"
        )

    def _named(self, block: Block) -> Block:
        """Return the candidates of a block that have all its names, and its sample."""
        named = map(self._is_of, block.parameters)
        indices = [i for i, is_named in enumerate(named) if is_named]
        return block.only(indices)

    def _is_of(self, parameters: Parameters) -> bool:
        names = [value for value in parameters.values() if isinstance(value, str)]
        names += [name.rpartition("/")[2] for name in names]
        unknown = f" {' '.join(self.names)} "
        for name in sorted(names, key=len, reverse=True):
            unknown = unknown.replace(f" {' '.join(_words(name))} ", "  ")
        if unknown.strip():
            return False
        number = parameters.get("number") or parameters.get("place")
        is_first = number == self.sample and not parameters.get("throughout")
        return self.sample is None or is_first


def _words(text: str) -> list[str]:
    """Return the words of a text, blanks or colons between; a sample's begins with @."""
    return [word for word in re.split(r"[\s:]+|(?=@)", text) if word]


def _size_expected(word: str, unit: str | None) -> str:
    """Return in words how a flaw's size is told, by its unit; without one it has none."""
    if not unit:
        return f"{word!r} has no size"
    return f"the size of {word!r} is above 0 and in {unit}, as in '{word} 3{unit}'"


def _words_like(word: str) -> str:
    """Return what a word is probably meant for, and all words."""
    near = difflib.get_close_matches(word, FLAWS, 1)
    meant = f"; did you mean {near[0]}?" if near else ""
    return f"{meant}; the words are {', '.join(FLAWS)}"
