"""Names of placements: as short as they can be while each has its own."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from .placement import Placement

NAMED = 2
"""Parts of its path that a placement is called by."""


def placement_name(folder: Path) -> str:
    """Return a placement's name: its folder's name after its parent's."""
    return "/".join(folder.resolve().parts[-NAMED:]).lstrip("/")


def distinctly_named(placements: Sequence[Placement]) -> list[Placement]:
    """Return placements of which no two of different folders have one name.

    Those of one name get the names of more folders above theirs, as far as these differ; those that
    were made in memory get a number.
    """
    folders = defaultdict[str, set[Path]](set)
    for placement in placements:
        if placement.path is not None:
            folders[placement.name].add(placement.path.resolve())
    counts = Counter[str]()
    renamed: list[Placement] = []
    for placement in placements:
        name = placement.name
        path = placement.path
        if path is not None and len(folders[name]) > 1:
            name = _name_among(path.resolve(), folders[name])
        elif path is None:
            counts[name] += 1
            number = counts[name] + bool(folders[name])
            if number > 1:
                name = f"{name} ({number})"
        if name != placement.name:
            placement = replace(placement, name=name)
        renamed.append(placement)
    return renamed


def _name_among(folder: Path, folders: Iterable[Path]) -> str:
    """Return the shortest name of a folder, of two parts at least, that no other one has."""
    parts = folder.parts[1:]
    others = [other.parts[1:] for other in folders if other != folder]
    for length in range(NAMED, len(parts)):
        name = parts[-length:]
        if all(name != other[-length:] for other in others):
            return "/".join(name)
    return "/".join(parts)
