"""The text of a MuJoCo model: edits that leave all else byte for byte as it was."""

import re
from collections.abc import Mapping
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

import numpy as np

from ...solver.robot.urdf_text import end_of_tag, with_attributes
from .export import ExportError

__all__ = ["add_text", "place_bodies"]

_TURNS = re.compile(rb"\s(euler|axisangle|xyaxes|zaxis)\s*=\s*(\"[^\"]*\"|'[^']*')")


def place_bodies(data: bytes, places: Mapping[str, np.ndarray], name: str) -> bytes:
    """Return the model with other places of some bodies.

    Args:
        data: The model's text.
        places: The new pose of each body on its parent, shape (4, 4), by the body's name.
        name: The file's name, for messages.

    Raises:
        ExportError: A body stands in a file that this one includes, has no name, or hangs in a
            ``<frame>``, which would move it on.
    """
    found: dict[str, tuple[int, int]] = {}
    path: list[str] = []
    parser = expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        if tag == "body" and attributes.get("name") in places:
            if {"frame", "replicate"} & set(path):
                raise ExportError(f"{name}: body {attributes['name']!r} hangs in a <frame>")
            begin = parser.CurrentByteIndex
            found[attributes["name"]] = (begin, end_of_tag(data, begin))
        path.append(tag)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: path.pop()
    parser.Parse(data, True)
    missing = [body or "(without a name)" for body in places if body not in found]
    if missing:
        raise ExportError(
            f"{name}: body {missing[0]} does not stand in this file; name it, or name by --like "
            "the file that holds it"
        )
    for body, (begin, end) in sorted(found.items(), key=lambda item: -item[1][0]):
        tag = _TURNS.sub(b"", data[begin:end])
        data = data[:begin] + with_attributes(tag, _attributes(places[body])) + data[end:]
    return data


def add_text(data: bytes, key: str, words: str) -> bytes:
    """Return the model with a text of its own before its end, by ``model.text(key)``."""
    end = data.rindex(b"</mujoco")
    new = f"  <custom><text name={quoteattr(key)} data={quoteattr(words)}/></custom>\n"
    return data[:end] + new.encode() + data[end:]


def _attributes(T: np.ndarray) -> dict[str, str]:
    import mujoco

    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(T[:3, :3]).ravel())
    return {
        key: " ".join(map(repr, values.tolist()))
        for key, values in (("pos", T[:3, 3]), ("quat", quat))
    }
