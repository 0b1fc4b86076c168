"""Paths of a URDF's meshes, from the folder where its calibrated copy stands."""

import os
import re
from pathlib import Path

from ..identification.robot import UrdfText, with_edits

_FILENAME = re.compile(rb"(\sfilename\s*=\s*)([\"'])(.*?)\2", re.DOTALL)


def relocate_meshes(text: UrdfText, source: Path, target: Path) -> bytes:
    """Return the text with relative mesh paths from one folder rewritten to be from another."""

    def moved(match: re.Match[bytes]) -> bytes:
        attribute, quote, name = match.groups()
        filename = name.decode()
        if "://" in filename or Path(filename).is_absolute():
            return match[0]
        mesh = (source / filename).resolve()
        path = os.path.relpath(mesh, target.resolve())
        return attribute + quote + path.encode() + quote

    edits: list[tuple[int, int, bytes]] = []
    for element in text.root.descendants():
        if element.tag in ("mesh", "texture"):
            begin, end = element.span
            tag = _FILENAME.sub(moved, text.data[begin:end], count=1)
            edits.append((begin, end, tag))
    return with_edits(text.data, edits)
