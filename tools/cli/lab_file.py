"""Options that a lab types once: ``mukca.toml`` beside its recordings, or in a folder above.

Its keys are options by their names, as in ``robot = "panda"``; a path counts from the file.
"""

import difflib
import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from ...errors import read_bytes, reason_of
from ...solver.calibration import UsageError
from ...solver.identification import robot as models

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

FILE = "mukca.toml"
VERBS = ("record", "extract", "check", "solve", "validate", "rezero", "fleet")
"""Verbs that read it."""
OF_ROBOT = ("robot", "base", "tip", "flange", "ball")
"""Options of the model: where one is typed, the file's are of another robot."""
KEYS = (*OF_ROBOT, "distance", "payload", "gravity", "repeatability-mm")
VECTORS = ("ball", "gravity")
"""Options whose numbers follow one name; others are typed once for each value."""


def lab_words(words: Sequence[str], names: Collection[str]) -> tuple[Path, list[str]]:
    """Return the nearest ``mukca.toml``, and the options in it that a command line lacks.

    Args:
        words: The command line, the verb first.
        names: Options of the verb, as ``--robot``.

    Raises:
        UsageError: The file cannot be read, or has a key or a value that is none.
    """
    file = _nearest(words)
    if words[0] not in VERBS or file is None:
        return Path(), []
    typed = {name for name in KEYS if any(_is(word, name) for word in words)}
    if typed.intersection(OF_ROBOT):
        typed.update(OF_ROBOT)
    options: list[str] = []
    for key, value in _read(file).items():
        name = key.replace("_", "-")
        if name not in typed and f"--{name}" in names:
            options += _typed(file, name, value)
    return file, options


def _is(word: str, name: str) -> bool:
    """Return whether a word is an option, perhaps cut short."""
    option = word.partition("=")[0]
    return len(option) > len("--") and f"--{name}".startswith(option)


def _nearest(words: Sequence[str]) -> Path | None:
    """Return the file beside or above the first folder that the words name, or the current one."""
    for folder in (*_folders(words), Path()):
        here = folder.resolve()
        for above in (here, *here.parents):
            if (above / FILE).is_file():
                return above / FILE
    return None


def _folders(words: Sequence[str]) -> Iterator[Path]:
    """Yield the folders that words name, or would be made in."""
    for word in words[1:]:
        path = Path(word)
        yield from (up for up in (path, *path.parents) if up.parts and up.is_dir())


def _read(file: Path) -> Mapping[str, Any]:
    """Return the keys of a file and their values."""
    try:
        values = tomllib.loads(read_bytes(file).decode())
    except (OSError, ValueError) as error:
        raise UsageError(f"{file}: {reason_of(error)}") from None
    for key in values:
        if key.replace("_", "-") not in KEYS:
            near = difflib.get_close_matches(key, KEYS, 1)
            advice = f"did you mean {near[0]}?" if near else f"keys: {', '.join(KEYS)}"
            raise UsageError(f"{file}: no key is called {key}; {advice}")
    return values


def _typed(file: Path, name: str, value: object) -> list[str]:
    """Return an option as it would be typed."""
    values = cast("list[object]", value) if isinstance(value, list) else [value]
    if not all(isinstance(item, str | int | float) for item in values):
        raise UsageError(
            f"{file}: {name}: expected a number, a text, or a list of them"
        )
    items = list(map(str, values))
    if name in VECTORS:
        return [f"--{name}", *items]
    for i, item in enumerate(items):
        before, separator, source = item.rpartition("=")
        if name == "robot":
            items[i] = before + separator + models.from_folder(source, file.parent)
    return [f"--{name}={item}" for item in items]
