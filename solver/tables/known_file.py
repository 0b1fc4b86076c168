"""Known distances between sockets, and coordinates of sockets, as files and words give them.

Files of known distances hold words, one a line, or a table with the columns
``from,to,distance [mm],deviation [mm]``, the last of which may be left out.

In tables ``#`` begins a note, and columns stand in any order, as in::

    from,to,distance [mm],deviation [mm]
    left:0,right:0,350.02,0.1
"""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from ...errors import MukcaError
from ...recorder import LENGTHS, Column, RecordingError, number_of, read_text, table_of
from ..identification.data import (
    CALIPER_DEVIATION,
    FrameError,
    KnownDistance,
    KnownError,
    SocketAt,
    is_called,
    metres,
)


def text_without_notes(file: Path) -> str:
    """Return the text of a file without what ``#`` begins."""
    return re.sub("#.*", "", read_text(file))


def read_lengths(
    file: Path, names: Sequence[str], lengths: Sequence[str], error: type[MukcaError]
) -> Iterator[tuple[int, list[str], list[float]]]:
    """Yield the line of each row, its names and its lengths [m].

    Args:
        file: A file with a header.
        names: Columns with names of things.
        lengths: Columns with lengths, whose unit the header names.
        error: What is raised for another table, or a cell that is no length.
    """
    header = ",".join([*names, *(f"{name} [mm]" for name in lengths)])
    try:
        text = text_without_notes(file)
        if not text.strip():
            raise RecordingError(
                f"{file}: empty; expected a CSV file with the header {header}"
            )
        table = table_of(text, file)
    except RecordingError as problem:
        raise error(str(problem)) from None
    columns: list[Column] = []
    for name in (*names, *lengths):
        called = [column for column in table.columns if column.name.lower() == name]
        if len(called) != 1:
            raise error(
                f"{file}:1: column {name!r}: expected one; a header is {header}"
            )
        columns += called
    of_lengths = columns[len(names) :]
    for column in of_lengths:
        if column.unit not in LENGTHS:
            raise error(f"{file}:1: {_words_of_unit(column)}")
    for line, cells in zip(table.lines, table.rows, strict=True):
        values: list[float] = []
        for column in of_lengths:
            cell = cells[column.index]
            try:
                values.append(LENGTHS[column.unit] * float(cell))
            except ValueError:
                raise error(f"{file}:{line}: {cell!r:.40} is no length") from None
        texts = [cells[column.index].strip() for column in columns[: len(names)]]
        yield line, texts, values


def _words_of_unit(column: Column) -> str:
    """Return what is wrong with the unit of a column of lengths, and what would be right."""
    unit = f"unit {column.unit!r}" if column.unit else "no unit"
    name = column.name
    return f"column {name} has {unit}; write {name} [mm] or [m]"


COLUMNS = ("frame", "socket", "x", "y", "z", "deviation")
LARGEST_DEVIATION = 1.0
"""No coordinates are measured worse than this [m]."""
_KNOWN = re.compile(r"(.+:\d+)-(.+:\d+)=([^+]+?)(?:\+-(.+))?")
_SOCKET = re.compile(r".+:\d+")
_WORDS = re.compile(r"([^=/]+)/(.+:\d+)=([^,]+),([^,]+),([^,]+?)\+-(.+)")
_FRAME = re.compile(r"[\w.-]+(:base)?")


def read_known(
    sources: Sequence[str | Path | KnownDistance],
) -> Iterator[str | KnownDistance]:
    """Yield known distances, one by one; a word that is a file stands for its lines or rows.

    Raises:
        KnownError: A table without its columns or their units.
    """
    for source in sources:
        if isinstance(source, KnownDistance):
            yield source
        elif Path(source).is_file():
            yield from _words(Path(source))
        else:
            yield str(source)


def _words(file: Path) -> Iterator[str]:
    """Yield the distances of a file in words."""
    text = text_without_notes(file)
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines or "=" in lines[0] or not re.search("[,;\t]", lines[0]):
        yield from lines
        return
    lengths = (
        ["distance", "deviation"] if "deviation" in lines[0].lower() else ["distance"]
    )
    for _, (first, second), values in read_lengths(
        file, ["from", "to"], lengths, KnownError
    ):
        yield f"{first}-{second}={'+-'.join(map(repr, values))}"


def parse_known(text: str) -> KnownDistance:
    """Return the distance in words like ``left:0-right:0=0.175+-0.0001`` (metres)."""
    match = _KNOWN.fullmatch(text.strip())
    try:
        if match is None:
            raise ValueError
        distance = metres(match[3])
        deviation = CALIPER_DEVIATION if match[4] is None else metres(match[4])
    except ValueError:
        raise KnownError(
            f"known distance {text!r}: expected A:0-B:0=0.175+-0.0001: placement, socket, "
            "distance and deviation in metres"
        ) from None
    if not (0 < distance < 20 and 0 < deviation < math.inf):
        raise KnownError(
            f"known distance {text!r}: distance and deviation are positive metres"
        )
    return KnownDistance(_label(match[1]), _label(match[2]), distance, deviation)


def _label(words: str) -> tuple[str, int]:
    """Return the socket in words like ``left:0``."""
    name, _, number = words.rpartition(":")
    return name, int(number)


def read_sockets_at(
    sources: str | Path | Iterable[str | Path | SocketAt],
) -> list[SocketAt]:
    """Return measured coordinates of sockets that files, words, or they themselves give.

    A CSV file; ``frame`` is a name of your own, ``base`` or ``NAME:base``; ``#`` begins a note::

        frame,socket,x [mm],y [mm],z [mm],deviation [mm]
        table,front:0,0,0,30,0.05
    """
    sockets: list[SocketAt] = []
    owners: dict[str, Path] = {}
    for source in [sources] if isinstance(sources, str | Path) else sources:
        if isinstance(source, SocketAt):
            sockets.append(source)
        elif "=" in str(source) and not Path(source).exists():
            sockets.append(parse_socket_at(str(source)))
        else:
            rows = _rows(file := Path(source))
            for frame in dict.fromkeys(row.frame for row in rows):
                if frame in owners:
                    raise FrameError(
                        f"{file}: frame {frame!r} is named twice, here and in {owners[frame]}; "
                        "give each frame a name of its own, or put its sockets into one file"
                    )
                owners[frame] = file
            sockets += rows
    return sockets


def parse_socket_at(words: str) -> SocketAt:
    """Return the coordinates in words like ``table/front:0=0.1,0.2,0.03+-0.00005`` (metres)."""
    match = _WORDS.fullmatch(words.strip())
    if match is None:
        raise FrameError(
            f"{words!r} is neither a file nor FRAME/PLACEMENT:0=X,Y,Z+-DEVIATION in metres"
        )
    frame, socket, *numbers = match.groups()
    values = [number_of(number) for number in numbers]
    return _socket_at(
        words, frame, socket, [math.nan if x is None else x for x in values]
    )


def _rows(file: Path) -> list[SocketAt]:
    """Return the coordinates in a file."""
    rows: list[SocketAt] = []
    line_of: dict[tuple[str, str], int] = {}
    for line, (frame, socket), values in read_lengths(
        file, COLUMNS[:2], COLUMNS[2:], FrameError
    ):
        first = line_of.setdefault((frame, socket), line)
        if first != line:
            raise FrameError(
                f"{file}:{line}: socket {socket} is twice in frame {frame!r}, as in line {first}"
            )
        rows.append(_socket_at(f"{file}:{line}", frame, socket, values))
    return rows


def _socket_at(
    where: str, frame: str, socket: str, values: Sequence[float]
) -> SocketAt:
    if not _SOCKET.fullmatch(socket):
        raise FrameError(f"{where}: socket {socket!r}: expected PLACEMENT:0")
    if not _FRAME.fullmatch(frame):
        raise FrameError(
            f"{where}: frame {frame!r} is no name: letters, digits, and . _ -"
        )
    x, y, z, deviation = values
    if not all(map(math.isfinite, values)) or deviation <= 0:
        raise FrameError(
            f"{where}: x, y, z are numbers, and the deviation a positive one"
        )
    if deviation > LARGEST_DEVIATION:
        raise FrameError(
            f"{where}: a deviation of {deviation:g} m tells nothing; check its unit"
        )
    return SocketAt(frame, _label(socket), (x, y, z), deviation, where)


def in_placements(
    sockets_at: Sequence[SocketAt], train: Sequence[str], test: Sequence[str]
) -> list[SocketAt]:
    """Return the coordinates of sockets in placements to train on; a fit is told of no others."""
    in_training: list[SocketAt] = []
    for socket in sockets_at:
        name = socket.socket[0]
        if any(is_called(placement, name) for placement in train):
            in_training.append(socket)
        elif not any(is_called(placement, name) for placement in test):
            raise FrameError(
                f"{socket.where}: no placement is called {name!r}; there are: "
                f"{', '.join((*train, *test))}"
            )
    return in_training
