"""Known distances and coordinates of sockets: from files, words, or as they are."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from ..data import KnownDistance, SocketAt, parse_socket_at, read_sockets_at


def read_distances(known: Sequence[str | Path | KnownDistance]) -> Iterable[str | KnownDistance]:
    """Yield known distances, one by one; a word that is a file stands for its lines."""
    for one in known:
        if isinstance(one, str | Path) and Path(one).is_file():
            text = Path(one).read_text(encoding="utf-8")
            lines = (line.split("#")[0] for line in text.splitlines())
            yield from (line for line in lines if line.strip())
        else:
            yield str(one) if isinstance(one, Path) else one


def read_coordinates(
    given: str | Path | SocketAt | Sequence[str | Path | SocketAt],
) -> list[SocketAt]:
    """Return the coordinates of sockets that files, words, or they themselves give."""
    every = [given] if isinstance(given, str | Path | SocketAt) else given
    ready = [one for one in every if isinstance(one, SocketAt)]
    others = [one for one in every if not isinstance(one, SocketAt)]
    words = [str(one) for one in others if "=" in str(one) and not Path(one).exists()]
    files = [one for one in others if str(one) not in words]
    return [*ready, *map(parse_socket_at, words), *read_sockets_at(files)]
