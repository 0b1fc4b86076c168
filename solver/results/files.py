"""Typed values to JSON files and back, and files written whole or not at all; paths of meshes.

A key that this version does not know is passed over, so files of later versions that only add
keys can still be read. A value that is left at its default is not written.
"""

import hashlib
import json
import os
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec

from ..._version import __version__
from ...errors import MukcaError, read_bytes, read_json
from ...recorder import make_folder, replace_files
from ..identification.robot import UrdfText, with_edits

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:  # Python 3.10 has none

    def dataclass_transform(**_):
        """Do nothing: the decorator is for type checkers."""
        return lambda cls: cls


_FILENAME = re.compile(rb"(\sfilename\s*=\s*)([\"'])(.*?)\2", re.DOTALL)


class DocumentError(MukcaError):
    """A file that a command is to read is missing, damaged, or of another kind."""


@dataclass_transform(kw_only_default=True, frozen_default=True)
class _Kind(msgspec.StructMeta):
    """Makes documents: each is frozen, and made by keywords unless its class says otherwise."""

    def __new__(cls, *parts: Any, kw_only: bool = True, **settings: Any) -> "_Kind":
        return super().__new__(cls, *parts, kw_only=kw_only, frozen=True, **settings)


class Document(msgspec.Struct, metaclass=_Kind, omit_defaults=True):
    """Base of all values that stand in a file."""

    @classmethod
    def filled(cls: type["Typed"], source: object, **extra: Any) -> "Typed":
        """Return a document that holds what a value holds by the same names, and more."""
        names = [name for name in cls.__struct_fields__ if hasattr(source, name)]
        return cls(**{name: getattr(source, name) for name in names} | extra)

    def as_dict(self) -> dict[str, Any]:
        """Return the value by name, as it stands in the file."""
        return msgspec.to_builtins(self)


class _Head(msgspec.Struct):
    """Head of a file, which tells its kind."""

    format: str


Typed = TypeVar("Typed", bound=Document)


def encode(
    document: object, indent: int | None = None, *, compact: bool = False
) -> bytes:
    """Return a document as JSON, in one line unless each level is indented; no number is NaN."""
    return json.dumps(
        msgspec.to_builtins(document),
        indent=indent,
        separators=(",", ":") if compact else None,
        allow_nan=False,
    ).encode()


def read(
    file: Path, kind: type[Typed], format_: str, older: str | None = None
) -> Typed:
    """Read a document of a kind, which says that format of itself.

    Older files, which say none, are known by the key ``older``. A :class:`DocumentError` names the
    key that is missing or damaged.
    """
    name = format_.split("-")[1] + ".json"
    try:
        # Python's own reader: names of files that are not UTF-8 are kept, as they were written.
        value = read_json(file)
        is_current = older is not None and older in value
        head = _Head(format_) if is_current else msgspec.convert(value, _Head)
    except OSError as error:
        raise DocumentError(f"{file}: {error.strerror}; expected a {name}") from None
    except (ValueError, TypeError, msgspec.ValidationError) as error:
        raise DocumentError(f"{file}: not a {name}: {error}") from None
    if head.format != format_:
        kind_of, _, number = format_.rpartition("-")
        number_of_file = head.format.removeprefix(f"{kind_of}-")
        if number_of_file.isdecimal() and int(number_of_file) > int(number):
            reads = (
                f"this one, {__version__}, reads {format_}; pip install --upgrade mukca"
            )
            raise DocumentError(
                f"{file}: written by a later mukca ({head.format}): {reads}"
            )
        raise DocumentError(f"{file}: not a {name} of this version ({format_})")
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        raise DocumentError(f"{file}: damaged {name}: {error}") from None


def format_of(file: Path) -> str:
    """Return what a file says of its own format; empty where it says nothing."""
    try:
        return msgspec.convert(read_json(file), _Head).format
    except (OSError, ValueError, msgspec.ValidationError):
        return ""


class OutputError(MukcaError):
    """Results cannot be written where they were asked for."""


def refuse_existing(
    folder: Path, names: Iterable[str] | None = None, *, force: bool
) -> None:
    """See that an output folder may be written, before the work begins.

    With names, only these files must not be there; with ``force`` they may.

    Raises:
        OutputError: The folder, or one of the files, exists and ``force`` is not given, or the
            folder is none.
    """
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder}: exists and is no folder; choose another")
    files = [folder] if names is None else [folder / name for name in names]
    taken = [] if force else [file for file in files if file.exists()]
    if taken:
        raise OutputError(
            f"{taken[0]}: exists; choose another, or overwrite it by force=True"
        )


def write_files(folder: Path, contents: Mapping[str, bytes]) -> dict[str, Path]:
    """Write files that belong together into a folder, made where missing, in their order.

    Names may have folders in them. Returns the paths by name.

    Raises:
        OutputError: One cannot be written. None is changed, or the line says which are new.
    """
    paths = {name: folder / name for name in contents}
    new_folders: list[Path] = []
    files: dict[Path, bytes] = {}
    try:
        for name, path in paths.items():
            # A link stays one.
            file = path.resolve() if path.is_symlink() else path
            if file.exists() and not file.is_file():
                raise OutputError(f"{file}: is no file; choose another")
            new_folders = make_folder(path.parent) + new_folders
            files[file] = contents[name]
        replace_files(files)
    except OSError as error:
        for new_folder in new_folders:
            with suppress(OSError):  # files are in it
                new_folder.rmdir()
        raise OutputError(
            f"{error.filename or folder}: cannot be written: {error.strerror}"
        ) from None
    return paths


def sha256(content: bytes) -> str:
    """Return the digest by which a document names another file."""
    return hashlib.sha256(content).hexdigest()


def require_beside(file: Path, digests: Mapping[str, str] | None) -> None:
    """See that files beside a document are those that were written with it, or are not there.

    Raises:
        DocumentError: One is another.
    """
    for name, digest in (digests or {}).items():
        beside = file.parent / name
        if beside.exists() and sha256(read_bytes(beside)) != digest:
            raise DocumentError(
                f"{beside}: not the one that {file.name} was written with, but edited, or of "
                "another run; keep it in another folder, or write both again"
            )


def missing_beside(file: Path, digests: Mapping[str, str] | None) -> list[str]:
    """Return a line for each file that was written with a document and is not beside it."""
    return [
        f"{file.parent / name}: missing, though {file.name} was written with it; mukca export "
        "--to urdf writes a URDF of the calibration"
        for name in digests or {}
        if not (file.parent / name).exists()
    ]


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
