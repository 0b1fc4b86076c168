"""Typed values to JSON files and back, and files written whole or not at all.

A key that this version does not know is passed over, so files of later versions that only add
keys can still be read. A value that is left at its default is not written.
"""

import json
import os
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec

from ..._version import __version__
from ...errors import MukcaError, read_json

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:  # Python 3.10 has none

    def dataclass_transform(**_):
        """Do nothing: the decorator is for type checkers."""
        return lambda cls: cls


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
        names = [name for name in cls.__struct_fields__ if name not in extra]
        return cls(
            **{n: getattr(source, n) for n in names if hasattr(source, n)}, **extra
        )

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
    value = msgspec.to_builtins(document)
    separators = (",", ":") if compact else None
    return json.dumps(
        value, indent=indent, separators=separators, allow_nan=False
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
        value = read_json(file, parse_constant=_refuse)
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


def _refuse(word: str) -> float:
    raise ValueError(f"it holds {word}, which is no number")


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
    """Write files into a folder, made where missing; return their paths by file name.

    Each is written under a temporary name first, then renamed.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            _write(folder / name, content)
    except OSError as error:
        raise OutputError(
            f"{error.filename or folder}: cannot be written: {error.strerror}"
        ) from None
    return {name: folder / name for name in contents}


def _write(path: Path, content: bytes) -> None:
    file = path.resolve()  # a link stays one
    if file.exists() and not file.is_file():
        raise OutputError(f"{file}: is no file; choose another")
    try:
        handle, temporary = tempfile.mkstemp(dir=file.parent, prefix=f".{file.name}.")
    except OSError as error:
        error.filename = str(path)
        raise
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, 0o644)  # noqa: PTH101  (mkstemp makes it private)
        Path(temporary).replace(file)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
