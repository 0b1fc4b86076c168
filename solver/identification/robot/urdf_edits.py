"""Edits of a URDF's text at the places of its tags, and nowhere else."""

import re
from collections.abc import Mapping, Sequence
from html import escape
from typing import NamedTuple

from .urdf_text import ModelError, Origin, UrdfText


class Edit(NamedTuple):
    """New text between two byte offsets of the old one."""

    begin: int
    end: int
    new: bytes


def with_edits(
    data: bytes,
    edits: Sequence[tuple[int, int, bytes]],
) -> bytes:
    """Return a text with new text between offsets, each of (first, last, new)."""
    for begin, end, new in sorted(edits, reverse=True):
        data = data[:begin] + new + data[end:]
    return data


def set_origins(text: UrdfText, origins: Mapping[str, Origin]) -> bytes:
    """Return the text with the origins of some joints replaced, and nothing else changed.

    Only numbers that differ are written, in the shortest form that reads back exactly.
    """
    edits: list[Edit] = []
    for joint, origin in origins.items():
        old = text.origins[joint]
        changed: dict[str, str] = {}
        if tuple(origin.xyz) != old.xyz:
            changed["xyz"] = _written(origin.xyz)
        if tuple(origin.rpy) != old.rpy:
            changed["rpy"] = _written(origin.rpy)
        if changed:
            edits.append(_edit_of_origin(text, joint, changed))
    return with_edits(text.data, edits)


def _edit_of_origin(
    text: UrdfText,
    joint: str,
    values: Mapping[str, str],
) -> Edit:
    """Return the edit by which a joint's origin has some attributes."""
    element = text.joints[joint]
    origin = element.first("origin")
    if origin is None:
        after = element.span[1]
        return Edit(after, after, with_attributes(b"<origin/>", values))
    begin, end = origin.span
    return Edit(begin, end, with_attributes(text.data[begin:end], values))


def _written(values: Sequence[float]) -> str:
    """Return numbers in their shortest form that reads back exactly."""
    return " ".join(map(repr, map(float, values)))


def with_attributes(tag: bytes, values: Mapping[str, str]) -> bytes:
    """Return a start tag with some attributes set, the others as they are."""
    for key, value in values.items():
        pattern = rb"(\s" + key.encode() + rb"\s*=\s*)(\"[^\"]*\"|'[^']*')"
        new = f'"{value}"'.encode()
        written = re.search(pattern, tag)
        if written:
            begin, end = written.span(2)
            tag = tag[:begin] + new + tag[end:]
            continue
        close = re.search(rb"\s*/?>$", tag)
        assert close is not None
        place = close.start()
        tag = tag[:place] + f" {key}=".encode() + new + tag[place:]
    return tag


def add_link(
    text: UrdfText,
    parent: str,
    origin: Origin,
    link: str,
) -> bytes:
    """Return the text with one more link, fixed at an origin to the link ``parent``.

    Its joint is called ``tool_joint`` for ``tool`` and ``tool_link``.

    Raises:
        ModelError: The model already has such a link or joint, or the name has blanks.
    """
    if link.split() != [link]:
        raise ModelError(f"{link!r}: a link's name has no blanks, and is not empty")
    joint = link.removesuffix("_link") + "_joint"
    if link in text.links or joint in text.joints:
        raise ModelError(
            f"the model already has {link!r} or {joint!r}; choose another name"
        )
    xyz = _written(origin.xyz)
    rpy = _written(origin.rpy)
    new = (
        f'  <link name="{escape(link)}"/>\n'
        f'  <joint name="{escape(joint)}" type="fixed">\n'
        f'    <parent link="{escape(parent)}"/>\n'
        f'    <child link="{escape(link)}"/>\n'
        f'    <origin xyz="{xyz}" rpy="{rpy}"/>\n'
        f"  </joint>\n"
    )
    return _with_end(text, new)


def add_comment(text: UrdfText, lines: Sequence[str]) -> bytes:
    """Return the text with a comment before its end."""
    words = re.sub("--+", "-", "\n       ".join(lines))
    return _with_end(text, f"  <!-- {words} -->\n")


def _with_end(text: UrdfText, new: str) -> bytes:
    """Return the text with more before the end of its root element."""
    end = text.root.end
    return with_edits(text.data, [Edit(end, end, new.encode())])
