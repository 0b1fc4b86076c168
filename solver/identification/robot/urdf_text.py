"""The text of a URDF: a safe first look, which expands no entity."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NoReturn
from xml.parsers import expat

from .encoding import ModelError, in_utf8

Vector = tuple[float, float, float]
_TAG = re.compile(rb"(?:[^\"'>]|\"[^\"]*\"|'[^']*')*>")


@dataclass(frozen=True)
class Origin:
    """A joint's ``<origin>`` as written: translation [m], and roll, pitch, yaw [rad]."""

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)

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
        for child in self.children:
            if child.tag == tag:
                return child
        return None

    def read(
        self,
        child: str,
        key: str,
        default: str = "",
    ) -> str:
        """Return an attribute of the first tag of a kind right inside it."""
        inside = self.first(child)
        return default if inside is None else inside.attributes.get(key, default)

    def descendants(self) -> Iterator["Element"]:
        """Yield all tags inside it, however deep they are nested."""
        waiting = [*self.children]
        while waiting:
            element = waiting.pop()
            yield element
            waiting += element.children


class UrdfText:
    """A URDF's text, with its joints and links; ``source`` is its name in messages.

    Raises:
        ModelError: A joint or link without a name or with one used twice, or an origin that is not
            three finite numbers.
    """

    def __init__(
        self,
        data: bytes,
        source: str,
        root: Element,
    ) -> None:
        self.data = data
        self.source = source
        self.root = root
        (self.name,) = _by_name(source, "robot", [root])
        self.links = _by_name(source, "link", root.children)
        self.joints = _by_name(source, "joint", root.children)
        self.origins: dict[str, Origin] = {}
        """The origin of each joint; the identity where none is written."""
        for name, joint in self.joints.items():
            self.origins[name] = _origin(source, name, joint)

    @cached_property
    def parents(self) -> dict[str, tuple[str, str]]:
        """The joint above each link but the root, and the link above that.

        Raises:
            ModelError: A joint without its two links, or a link with two parents.
        """
        parents: dict[str, tuple[str, str]] = {}
        for name in self.joints:
            parent = self._link(name, "parent")
            child = self._link(name, "child")
            if child in parents:
                raise ModelError(
                    f"{self.source}: link {child!r} has two parents, joints "
                    f"{parents[child][0]!r} and {name!r}: a loop, where a tree is needed"
                )
            parents[child] = name, parent
        return parents

    def _link(self, joint: str, role: str) -> str:
        """Return the ``parent`` or the ``child`` of a joint."""
        link = self.joints[joint].read(role, "link")
        where = f"{self.source}: joint {joint!r}"
        if not link:
            raise ModelError(f'{where} has no <{role} link="...">')
        if link not in self.links:
            raise ModelError(f"{where} names a missing link {link!r}")
        return link


def _by_name(
    source: str,
    tag: str,
    elements: Iterable[Element],
) -> dict[str, Element]:
    """Return the elements of a kind by their names, which must be different."""
    by_name: dict[str, Element] = {}
    for element in elements:
        if element.tag != tag:
            continue
        name = element.attributes.get("name", "")
        where = f"{source}:{element.line}"
        if not name:
            raise ModelError(f"{where}: a <{tag}> without a name")
        if name in by_name:
            raise ModelError(f"{where}: a second <{tag}> is called {name!r}")
        by_name[name] = element
    return by_name


def _origin(source: str, name: str, joint: Element) -> Origin:
    """Return a joint's origin, the identity where none is written."""
    element = joint.first("origin")
    if element is None:
        return Origin()
    where = f"{source}:{element.line}: joint {name!r}"
    for key in element.attributes:
        if "quat" in key or key in ("xyzw", "wxyz"):
            raise ModelError(
                f"{where}: origin has {key}, which is not read; write its rotation as rpy [rad]"
            )
    get = element.attributes.get
    x, y, z = numbers(get("xyz", "0 0 0"), where, "origin xyz", 3)
    roll, pitch, yaw = numbers(get("rpy", "0 0 0"), where, "origin rpy", 3)
    return Origin((x, y, z), (roll, pitch, yaw))


def numbers(
    words: str,
    where: str,
    what: str,
    count: int,
    *,
    finite: bool = True,
) -> list[float]:
    """Return the numbers in an attribute; messages begin with ``where``."""
    expected = "a number" if count == 1 else f"{count} numbers with blanks between"
    try:
        values = [float(word) for word in words.split()]
    except ValueError:
        raise ModelError(
            f"{where}: not a valid URDF: {what} {words!r}, where {expected} must be"
        ) from None
    if len(values) != count or (finite and not all(map(math.isfinite, values))):
        kind = "a finite number" if count == 1 else f"{count} finite numbers"
        raise ModelError(f"{where}: {what} {words!r} is not {kind}")
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
    tree = _TreeBuilder(data, source)
    try:
        tree.parser.Parse(data, True)
    except expat.ExpatError as error:
        reason = expat.errors.messages[error.code]
        raise ModelError(f"{source}:{error.lineno}: not XML: {reason}") from None
    [root] = tree.document.children
    return UrdfText(data, source, root)


_MACRO = re.compile(r"macro\b|xacro:|.*\$[{(]", re.DOTALL)
"""A tag and its attributes that xacro expands."""
UNUSED = {"xacro:property", "xacro:arg"}
"""Tags of values by name. One that nothing uses changes nothing; what uses one is templated."""


class _TreeBuilder:
    """Puts the tags that a parser meets into a tree, and refuses those of other files."""

    def __init__(self, data: bytes, source: str) -> None:
        self.data = data
        self.source = source
        self.document = Element("", {}, 0, (0, 0))
        self.open_elements = [self.document]
        self.parser = expat.ParserCreate("utf-8")
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.StartDoctypeDeclHandler = self.doctype

    def start(
        self,
        tag: str,
        attributes: dict[str, str],
    ) -> None:
        """Begin an element."""
        parent = self.open_elements[-1]
        if parent is self.document and tag != "robot":
            self.refuse(f"the outermost element is <{tag}>, a URDF's is <robot>")
        words = " ".join((tag, *attributes.values()))
        if _MACRO.match(words) and UNUSED.isdisjoint((tag, parent.tag)):
            self.refuse(
                "this is a xacro file; expand it first: xacro FILE > robot.urdf"
            )
        begin = self.parser.CurrentByteIndex
        span = begin, end_of_tag(self.data, begin)
        element = Element(tag, attributes, self.parser.CurrentLineNumber, span)
        parent.children.append(element)
        self.open_elements.append(element)

    def end(self, _: str) -> None:
        """End the last element that was begun."""
        element = self.open_elements.pop()
        element.end = self.parser.CurrentByteIndex

    def doctype(self, *_: object) -> None:
        """Refuse a document type."""
        self.refuse(
            "document type and entity declarations are refused; remove <!DOCTYPE ...>"
        )

    def refuse(self, reason: str) -> NoReturn:
        """Raise an error that names the line."""
        line = self.parser.CurrentLineNumber
        raise ModelError(f"{self.source}:{line}: {reason}")


def end_of_tag(data: bytes, begin: int) -> int:
    """Return the offset just after the ``>`` that closes the start tag at ``begin``."""
    tag = _TAG.match(data, begin)
    return tag.end() if tag else len(data)
