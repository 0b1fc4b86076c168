"""The text of a MuJoCo model: edits that leave all else byte for byte as it was."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

import numpy as np

from ...solver.robot import end_of_tag, with_attributes, with_edits
from .request import ExportError

_TURNS = re.compile(rb"\s(euler|axisangle|xyaxes|zaxis)\s*=\s*(\"[^\"]*\"|'[^']*')")


def place_bodies(model: Path, places: Mapping[str, np.ndarray]) -> tuple[Path, bytes]:
    """Return the one file that holds some bodies, with other poses on their parents, (4, 4)."""
    for file, data, begins in _files(model, model.parent, places):
        if len(begins) < len(places):
            continue
        edits: list[tuple[int, int, bytes]] = []
        for body, begin in begins.items():
            end = end_of_tag(data, begin)
            tag = with_attributes(_TURNS.sub(b"", data[begin:end]), _attributes(places[body]))
            edits.append((begin, end, tag))
        return file, with_edits(data, edits)
    raise ExportError(
        f"{model}: neither it nor a file that it includes holds all bodies of the arm: "
        f"{', '.join(body or '(one without a name)' for body in places)}"
    )


def _files(
    file: Path, folder: Path, places: Mapping[str, np.ndarray]
) -> Iterator[tuple[Path, bytes, dict[str, int]]]:
    """Yield a model and what it includes: each file, its text, and where bodies begin in it."""
    data = file.read_bytes()
    begins: dict[str, int] = {}
    included: list[str] = []
    path: list[str] = []
    parser = expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        if tag == "include":
            included.append(attributes.get("file", ""))
        if tag == "body" and attributes.get("name") in places:
            if {"frame", "replicate"} & set(path):
                raise ExportError(f"{file}: body {attributes['name']!r} hangs in a <frame>")
            begins[attributes["name"]] = parser.CurrentByteIndex
        path.append(tag)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: path.pop()
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:  # MuJoCo is more lenient
        raise ExportError(f"{file}: not well-formed XML: {error}") from None
    yield file, data, begins
    for name in included:
        for place in (folder, file.parent):
            if (place / name).is_file():
                yield from _files(place / name, folder, places)
                break


def add_text(data: bytes, words: str, key: str | None) -> bytes:
    """Return the model with a text, read by ``model.text(key)``; without a key as a comment."""
    new = f"<custom><text name={quoteattr(key)} data={quoteattr(words)}/></custom>" if key else ""
    new = new or f"<!-- {re.sub('--+', '-', words)} -->"
    end = data.rindex(b"</mujoco")
    return with_edits(data, [(end, end, f"  {new}\n".encode())])


def _attributes(T: np.ndarray) -> dict[str, str]:
    import mujoco

    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(T[:3, :3]).ravel())
    words = {"pos": T[:3, 3], "quat": quat}
    return {key: " ".join(map(repr, values.tolist())) for key, values in words.items()}
