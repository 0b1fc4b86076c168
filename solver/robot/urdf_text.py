"""The text of a URDF: a safe first look, and edits at the places of its tags, nowhere else."""

import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from itertools import chain
from pathlib import Path
from xml.parsers import expat

from .encoding import ModelError, in_utf8

_TAG = re.compile(rb"(?:[^\"'>]|\"[^\"]*\"|'[^']*')*>")


@dataclass(frozen=True)
class Origin:
    """A joint's ``<origin>`` as written: translation [m], and roll, pitch, yaw [rad]."""

    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def numbers(self) -> tuple[float, ...]:
        """Six numbers, x y z roll pitch yaw."""
        return self.xyz + self.rpy

    @staticmethod
    def of(values: Iterable[float]) -> "Origin":
        """Return the origin of six numbers, x y z roll pitch yaw."""
        x, y, z, roll, pitch, yaw = map(float, values)
        return Origin((x, y, z), (roll, pitch, yaw))


@dataclass
class Element:
    """A tag, and the tags right inside it."""

    tag: str
    attributes: Mapping[str, str]
    line: int
    span: tuple[int, int]
    """First and last byte offset of the start tag."""
    end: int = 0
    """Byte offset of the end tag."""
    children: list["Element"] = field(default_factory=list["Element"])

    def first(self, tag: str) -> "Element | None":
        """Return the first tag of a kind right inside it."""
        return next((child for child in self.children if child.tag == tag), None)

    def read(self, child: str, key: str, default: str = "") -> str:
        """Return an attribute of the first tag of a kind right inside it."""
        inside = self.first(child)
        return default if inside is None else inside.attributes.get(key, default)

    def descendants(self) -> Iterator["Element"]:
        """Yield all tags inside it."""
        for child in self.children:
            yield child
            yield from child.descendants()


class UrdfText:
    """A URDF's text, with its joints and links; ``source`` is its name in messages.

    Raises:
        ModelError: A joint or link without a name or with one used twice, or an origin that is not
            three finite numbers.
    """

    def __init__(self, data: bytes, source: str, root: Element) -> None:
        self.data, self.source, self.root = data, source, root
        (self.name,) = _by_name(source, "robot", [root])
        self.links = _by_name(source, "link", root.children)
        self.joints = _by_name(source, "joint", root.children)
        self.origins = {
            name: _origin(source, name, joint) for name, joint in self.joints.items()
        }
        """The origin of each joint; the identity where none is written."""

    @cached_property
    def parents(self) -> dict[str, tuple[str, str]]:
        """The joint above each link but the root, and the link above that.

        Raises:
            ModelError: A joint without its two links, or a link with two parents.
        """
        parents: dict[str, tuple[str, str]] = {}
        for name, joint in self.joints.items():
            links = {role: joint.read(role, "link") for role in ("parent", "child")}
            for role, link in links.items():
                if not link:
                    raise ModelError(
                        f'{self.source}: joint {name!r} has no <{role} link="...">'
                    )
                if link not in self.links:
                    raise ModelError(
                        f"{self.source}: joint {name!r} names a missing link {link!r}"
                    )
            child = links["child"]
            if child in parents:
                raise ModelError(
                    f"{self.source}: link {child!r} has two parents, joints "
                    f"{parents[child][0]!r} and {name!r}: a loop, where a tree is needed"
                )
            parents[child] = name, links["parent"]
        return parents


def _by_name(source: str, tag: str, elements: Iterable[Element]) -> dict[str, Element]:
    by_name: dict[str, Element] = {}
    for element in elements:
        if element.tag != tag:
            continue
        name = element.attributes.get("name", "")
        if not name:
            raise ModelError(f"{source}:{element.line}: a <{tag}> without a name")
        if name in by_name:
            raise ModelError(
                f"{source}:{element.line}: a second <{tag}> is called {name!r}"
            )
        by_name[name] = element
    return by_name


def _origin(source: str, name: str, joint: Element) -> Origin:
    where = f"{source}:{(joint.first('origin') or joint).line}: joint {name!r}"
    words = (joint.read("origin", key, "0 0 0") for key in ("xyz", "rpy"))
    return Origin.of(
        chain.from_iterable(numbers(part, where, "origin", 3) for part in words)
    )


def numbers(
    words: str, where: str, what: str, count: int, *, finite: bool = True
) -> list[float]:
    """Return the numbers in an attribute; messages begin with ``where``."""
    try:
        values = [float(word) for word in words.split()]
    except ValueError:
        raise ModelError(
            f"{where}: not a valid URDF: {what} {words!r} is no number"
        ) from None
    if len(values) != count or (finite and not all(map(math.isfinite, values))):
        raise ModelError(f"{where}: {what} {words!r} is not {count} finite numbers")
    return values


def scan(data: bytes, source: str) -> UrdfText:
    """Find the tags that may be edited, and refuse a file that is no plain URDF.

    No entity is ever expanded.

    Raises:
        ModelError: Of no encoding that is known, not XML, a document type or entity declaration, a
            xacro file, no ``<robot>``, or what :class:`UrdfText` refuses. The message begins with
            the source.
    """
    data = in_utf8(data, source)
    parser = expat.ParserCreate("utf-8")
    document = Element("", {}, 0, (0, 0))
    opened = [document]

    def refuse(reason: str) -> ModelError:
        return ModelError(f"{source}:{parser.CurrentLineNumber}: {reason}")

    def start(tag: str, attributes: dict[str, str]) -> None:
        if opened[-1] is document and tag != "robot":
            raise refuse(f"the outermost element is <{tag}>, a URDF's is <robot>")
        templated = any("${" in value or "$(" in value for value in attributes.values())
        if tag.startswith("xacro:") or tag == "macro" or templated:
            raise refuse(
                "this is a xacro file; expand it first: xacro FILE > robot.urdf"
            )
        begin = parser.CurrentByteIndex
        span = begin, end_of_tag(data, begin)
        element = Element(tag, attributes, parser.CurrentLineNumber, span)
        opened[-1].children.append(element)
        opened.append(element)

    def end(_: str) -> None:
        opened.pop().end = parser.CurrentByteIndex

    def doctype(*_: object) -> None:
        raise refuse(
            "document type and entity declarations are refused; remove <!DOCTYPE ...>"
        )

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        reason = expat.errors.messages[error.code]
        raise ModelError(f"{source}:{error.lineno}: not XML: {reason}") from None
    return UrdfText(data, source, document.children[0])


def end_of_tag(data: bytes, begin: int) -> int:
    """Return the offset just after the ``>`` that closes the start tag at ``begin``."""
    tag = _TAG.match(data, begin)
    return tag.end() if tag else len(data)


def set_origins(text: UrdfText, origins: Mapping[str, Origin]) -> bytes:
    """Return the text with the origins of some joints replaced, and nothing else changed.

    Only numbers that differ are written, in the shortest form that reads back exactly.
    """
    edits: list[tuple[int, int, bytes]] = []
    for joint, origin in origins.items():
        old = text.origins[joint]
        changed = {
            key: " ".join(map(repr, map(float, new)))
            for key, new, before in (
                ("xyz", origin.xyz, old.xyz),
                ("rpy", origin.rpy, old.rpy),
            )
            if tuple(new) != before
        }
        if changed:
            element = text.joints[joint]
            after = element.span[1]  # where a joint without an origin gets its own
            written = element.first("origin")
            begin, end = written.span if written else (after, after)
            tag = text.data[begin:end] or b"<origin/>"
            edits.append((begin, end, with_attributes(tag, changed)))
    return with_edits(text.data, edits)


def with_attributes(tag: bytes, values: Mapping[str, str]) -> bytes:
    """Return a start tag with some attributes set, the others as they are."""
    for key, value in values.items():
        pattern = re.compile(rb"(\s" + key.encode() + rb"\s*=\s*)(\"[^\"]*\"|'[^']*')")
        new = f'"{value}"'.encode()
        if pattern.search(tag):
            tag = pattern.sub(lambda match, new=new: match[1] + new, tag, count=1)
        else:
            close = re.search(rb"\s*/?>$", tag)
            assert close is not None
            tag = (
                tag[: close.start()] + f" {key}=".encode() + new + tag[close.start() :]
            )
    return tag


def relocate_meshes(text: UrdfText, source: Path, target: Path) -> bytes:
    """Return the text with relative mesh paths from one folder rewritten to be from another."""

    def moved(match: re.Match[bytes]) -> bytes:
        filename = match[3].decode()
        if "://" in filename or Path(filename).is_absolute():
            return match[0]
        path = os.path.relpath((source / filename).resolve(), target.resolve())
        return match[1] + match[2] + path.encode() + match[2]

    attribute = re.compile(rb"(\sfilename\s*=\s*)([\"'])(.*?)\2", re.DOTALL)
    edits: list[tuple[int, int, bytes]] = []
    for element in text.root.descendants():
        if element.tag in ("mesh", "texture"):
            begin, end = element.span
            tag = attribute.sub(moved, text.data[begin:end], count=1)
            edits.append((begin, end, tag))
    return with_edits(text.data, edits)


def add_link(text: UrdfText, parent: str, origin: Origin, link: str) -> bytes:
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
    xyz = " ".join(map(repr, map(float, origin.xyz)))
    rpy = " ".join(map(repr, map(float, origin.rpy)))
    new = (
        f"  <link name={_quoted(link)}/>\n"
        f'  <joint name={_quoted(joint)} type="fixed">\n'
        f"    <parent link={_quoted(parent)}/>\n"
        f"    <child link={_quoted(link)}/>\n"
        f'    <origin xyz="{xyz}" rpy="{rpy}"/>\n'
        f"  </joint>\n"
    )
    return with_edits(text.data, [(text.root.end, text.root.end, new.encode())])


def add_comment(text: UrdfText, lines: Sequence[str]) -> bytes:
    """Return the text with a comment before its end."""
    words = re.sub("--+", "-", "\n       ".join(lines))
    comment = f"  <!-- {words} -->\n".encode()
    return with_edits(text.data, [(text.root.end, text.root.end, comment)])


def with_edits(data: bytes, edits: list[tuple[int, int, bytes]]) -> bytes:
    """Return a text with new text between offsets, each of (first, last, new)."""
    for begin, end, new in sorted(edits, reverse=True):
        data = data[:begin] + new + data[end:]
    return data


def _quoted(name: str) -> str:
    return f'"{escape(name)}"'
