"""The text of a URDF: a safe first look, and edits at the places of its tags, nowhere else."""

import math
import os
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from xml.parsers import expat

from ...errors import MukcaError

_TAG = re.compile(rb"(?:[^\"'>]|\"[^\"]*\"|'[^']*')*>")


class ModelError(MukcaError):
    """A robot model cannot be read, or is not what calibration needs."""


@dataclass(frozen=True)
class Origin:
    """A joint's ``<origin>`` as written: translation [m], and roll, pitch, yaw [rad]."""

    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @staticmethod
    def of(numbers: Iterable[float]) -> "Origin":
        """Return the origin of six numbers, x y z roll pitch yaw."""
        x, y, z, roll, pitch, yaw = map(float, numbers)
        return Origin((x, y, z), (roll, pitch, yaw))


@dataclass
class Element:
    """A start tag, and the first tag of each kind right inside it."""

    attributes: Mapping[str, str]
    span: tuple[int, int]
    """First and last byte offset of the tag."""
    children: dict[str, "Element"] = field(default_factory=dict[str, "Element"])

    def read(self, child: str, key: str, default: str = "") -> str:
        """Return an attribute of a tag right inside it."""
        return (
            self.children[child].attributes.get(key, default) if child in self.children else default
        )


@dataclass
class UrdfText:
    """A URDF's text, what it says, and where the tags stand that may be edited."""

    data: bytes
    source: str
    """Its name in messages."""
    name: str = ""
    """The robot's name."""
    joints: dict[str, Element] = field(default_factory=dict[str, Element])
    links: dict[str, Element] = field(default_factory=dict[str, Element])
    origins: dict[str, Origin] = field(default_factory=dict[str, Origin])
    """The origin of each joint; the identity where none is written."""
    filename_tags: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])
    """Start tags of meshes and textures."""
    robot_end: int = 0
    """Byte offset of ``</robot>``."""


def scan(data: bytes, source: str) -> UrdfText:
    """Find the tags that may be edited, and refuse a file that is no plain URDF.

    Raises:
        ModelError: Not UTF-8, not XML, a document type or entity declaration, a xacro file, no
            ``<robot>``, a joint or link without a name or with one used twice, an origin that
            is not three finite numbers. The message begins with the source.
    """
    return _Scanner(data, source).run()


class _Scanner:
    """Reads the text once with expat, and notes where the tags are. No entity is ever expanded."""

    def __init__(self, data: bytes, source: str) -> None:
        self.text = UrdfText(data.removeprefix(b"\xef\xbb\xbf"), source)
        self.open: list[Element] = []
        self.joint = ""
        self.parser = expat.ParserCreate("utf-8")
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.StartDoctypeDeclHandler = self.refuse_doctype

    def run(self) -> UrdfText:
        try:
            self.parser.Parse(self.text.data, True)
        except expat.ExpatError as error:
            reason = expat.errors.messages[error.code]
            raise ModelError(f"{self.text.source}:{error.lineno}: not XML: {reason}") from None
        return self.text

    def fail(self, reason: str) -> ModelError:
        return ModelError(f"{self.text.source}:{self.parser.CurrentLineNumber}: {reason}")

    def refuse_doctype(self, *_: object) -> None:
        raise self.fail("document type and entity declarations are refused; remove <!DOCTYPE ...>")

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        text, depth, begin = self.text, len(self.open), self.parser.CurrentByteIndex
        if not depth and tag != "robot":
            raise self.fail(f"the outermost element is <{tag}>, a URDF's is <robot>")
        if tag.startswith("xacro:"):
            raise self.fail("this is a xacro file; expand it first: xacro FILE > robot.urdf")
        element = Element(attributes, (begin, end_of_tag(text.data, begin)))
        if depth == 0:
            text.name = self.new_name(attributes, tag, ())
        elif depth == 1:
            self.joint = ""
            if tag == "link":
                text.links[self.new_name(attributes, tag, text.links)] = element
            elif tag == "joint":
                self.joint = self.new_name(attributes, tag, text.joints)
                text.joints[self.joint], text.origins[self.joint] = element, Origin()
        elif depth == 2 and self.joint and tag == "origin" and tag not in self.open[1].children:
            xyz, rpy = (self.triple(attributes.get(key, "0 0 0")) for key in ("xyz", "rpy"))
            text.origins[self.joint] = Origin(xyz, rpy)
        if depth:
            self.open[-1].children.setdefault(tag, element)
        if "filename" in attributes and tag in {"mesh", "texture"}:
            text.filename_tags.append(element.span)
        self.open.append(element)

    def end(self, tag: str) -> None:
        self.open.pop()
        if not self.open:
            self.text.robot_end = self.parser.CurrentByteIndex

    def new_name(self, attributes: Mapping[str, str], tag: str, known: Collection[str]) -> str:
        name = attributes.get("name", "")
        if not name:
            raise self.fail(f"a <{tag}> without a name")
        if name in known:
            raise self.fail(f"a second <{tag}> is called {name!r}")
        return name

    def triple(self, words: str) -> tuple[float, float, float]:
        try:
            x, y, z = (float(word) for word in words.split())
        except ValueError:
            x = y = z = math.nan
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
            raise self.fail(f"joint {self.joint!r}: origin {words!r} is not three finite numbers")
        return (x, y, z)


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
            for key, new, before in (("xyz", origin.xyz, old.xyz), ("rpy", origin.rpy, old.rpy))
            if tuple(new) != before
        }
        if changed:
            element = text.joints[joint]
            after = element.span[1]  # where a joint without an origin gets its own
            written = element.children.get("origin")
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
            tag = tag[: close.start()] + f" {key}=".encode() + new + tag[close.start() :]
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
    edits = [
        (begin, end, attribute.sub(moved, text.data[begin:end], count=1))
        for begin, end in text.filename_tags
    ]
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
        raise ModelError(f"the model already has {link!r} or {joint!r}; choose another name")
    xyz, rpy = (" ".join(map(repr, map(float, part))) for part in (origin.xyz, origin.rpy))
    new = (
        f"  <link name={_quoted(link)}/>\n"
        f'  <joint name={_quoted(joint)} type="fixed">\n'
        f"    <parent link={_quoted(parent)}/>\n"
        f"    <child link={_quoted(link)}/>\n"
        f'    <origin xyz="{xyz}" rpy="{rpy}"/>\n'
        f"  </joint>\n"
    )
    return with_edits(text.data, [(text.robot_end, text.robot_end, new.encode())])


def add_comment(text: UrdfText, lines: Sequence[str]) -> bytes:
    """Return the text with a comment before its end."""
    words = "\n       ".join(lines).replace("--", "-")
    return with_edits(
        text.data, [(text.robot_end, text.robot_end, f"  <!-- {words} -->\n".encode())]
    )


def with_edits(data: bytes, edits: list[tuple[int, int, bytes]]) -> bytes:
    """Return a text with new text between offsets, each of (first, last, new)."""
    for begin, end, new in sorted(edits, reverse=True):
        data = data[:begin] + new + data[end:]
    return data


def _quoted(name: str) -> str:
    return f'"{escape(name)}"'
