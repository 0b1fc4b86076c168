"""Distances between sockets that were measured from outside, against those the models predict."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ... import MukcaError
from .evidence import MODELS, Evidence, Seen

__all__ = ["KnownDistance", "KnownDistanceError", "between", "parse_known"]

_FORM = re.compile(r"(.+):(\d+)-(.+):(\d+)\s*=\s*([^=+]+?)\s*(?:\+-(.+))?")


class KnownDistanceError(MukcaError):
    """A known distance that cannot be read, or names no socket."""


@dataclass(frozen=True)
class KnownDistance:
    """A distance between two sockets, measured from outside the robot."""

    a: str
    """A placement's name, or its last part."""
    a_socket: int
    b: str
    b_socket: int
    distance: float
    """[m]."""
    deviation: float
    """Standard deviation [m]; 0 where none is given."""


def parse_known(words: Sequence[str]) -> list[KnownDistance]:
    """Return the known distances that words of the command line stand for.

    Args:
        words: ``A:0-B:0=0.175`` or ``A:0-B:0=0.175+-0.0001`` (metres), or files with one such
            entry a line; ``#`` begins a comment.

    Raises:
        KnownDistanceError: Anything else.
    """
    known: list[KnownDistance] = []
    for word in words:
        if "=" in word:
            known.append(_parse(word, word))
        else:
            known.extend(_parse(text, where) for where, text in _lines(Path(word)))
    return known


def _lines(file: Path) -> list[tuple[str, str]]:
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise KnownDistanceError(
            f"--known {file}: {getattr(error, 'strerror', None) or 'not a text file'}; give "
            "A:0-B:0=0.175 (metres), or a file with one such entry a line"
        ) from None
    texts = [(f"{file}:{i}", line.split("#")[0].strip()) for i, line in enumerate(lines, 1)]
    return [(where, text) for where, text in texts if text]


def _parse(text: str, where: str) -> KnownDistance:
    match = _FORM.fullmatch(text)
    try:
        if match is None:
            raise ValueError
        distance, deviation = float(match[5]), float(match[6] or 0)
        if not (0 < distance < math.inf and 0 <= deviation < math.inf):
            raise ValueError
    except ValueError:
        raise KnownDistanceError(
            f"{where}: {text!r} is no known distance; write PLACEMENT:SOCKET-PLACEMENT:SOCKET=M, "
            "for example left:0-right:0=0.350+-0.0001 (metres)"
        ) from None
    return KnownDistance(match[1], int(match[2]), match[3], int(match[4]), distance, deviation)


def between(evidence: Evidence, known: Sequence[KnownDistance]) -> list[dict[str, Any]]:
    """Return each known distance and the errors of the models [m].

    Raises:
        KnownDistanceError: One names a placement or socket that the calibration has no samples of.
    """
    rows: list[dict[str, Any]] = []
    for one in known:
        a, b = _find(evidence, one.a), _find(evidence, one.b)
        row: dict[str, Any] = {
            "a": f"{a.name}:{one.a_socket}",
            "b": f"{b.name}:{one.b_socket}",
            "distance": one.distance,
            "standard_deviation": one.deviation,
            "trained_on": a.role == b.role == "train",
        }
        for model in MODELS:
            span = _centre(b, one.b_socket, model) - _centre(a, one.a_socket, model)
            row[f"{model}_error"] = float(np.linalg.norm(span)) - one.distance
        rows.append(row)
    return rows


def _find(evidence: Evidence, name: str) -> Seen:
    for matches in (
        [seen for seen in evidence.placements if seen.name == name],
        [seen for seen in evidence.placements if seen.name.split("/")[-1] == name],
    ):
        if len(matches) == 1:
            return matches[0]
    names = ", ".join(seen.name for seen in evidence.placements)
    raise KnownDistanceError(f"--known: {name!r} names no one placement; there are: {names}")


def _centre(seen: Seen, socket: int, model: str) -> Any:
    if socket not in seen.measured.sockets:
        raise KnownDistanceError(f"--known: {seen.name} has no samples in socket {socket}")
    return seen.centres(model)[seen.measured.sockets.index(socket)]
