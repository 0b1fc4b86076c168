"""The ``geometric_calibration`` of PAL Robotics' robots, added to a URDF.

Each entry, as ``arm_1_dx`` of ``arm_1_joint``, is added to a number of the joint's origin: dx, dy,
dz [m] to ``xyz``, and droll, dpitch, dyaw [rad] to ``rpy`` as it is written there.
"""

import re
from collections.abc import Iterator
from pathlib import Path

from ....errors import LARGEST_DOCUMENT, read_bytes, reason_of
from .parameters import COMPONENTS
from .urdf_edits import set_origins
from .urdf_text import ModelError, Origin, UrdfText

ON_ROBOT = "/etc/calibration/master_calibration.yaml"
_EMPTY = "robot_state_publisher:\n  geometric_calibration:\n"
_BLOCK = re.compile(
    r"^([ \t]*)geometric_calibration:[ \t]*(?:\{\}[ \t]*)?(?:#.*)?$\n?", re.M
)
_ENTRY = re.compile(
    rf"(\w+)_d({'|'.join(COMPONENTS)})[ \t]*:[ \t]*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
)


def added(text: UrdfText, file: str) -> bytes:
    """Return a URDF's text with the entries of a file added to the origins of its joints.

    Raises:
        ModelError: The file cannot be read or has no such block, or a line in it is no entry, of no
            joint of the URDF, or of a number that has one already; or there is no line.
    """
    origins = {name: [*origin.numbers] for name, origin in text.origins.items()}
    seen = set[str]()
    for where, line in _lines(file):
        entry = _ENTRY.fullmatch(line)
        if entry is None:
            names = ", ".join(f"d{component}" for component in COMPONENTS)
            raise ModelError(
                f"{where}: expected an entry such as arm_1_dx: 0.001, with one of {names}"
            )
        name, component, number = entry.groups()
        joint = f"{name}_joint"
        if joint not in origins:
            raise ModelError(
                f"{where}: no joint of the URDF is called {joint!r}; take the line out, or give "
                "the URDF of the whole robot"
            )
        key = f"{name}_d{component}"
        if key in seen:
            raise ModelError(f"{where}: another line has {key!r}, too; take one out")
        seen.add(key)
        origins[joint][COMPONENTS.index(component)] += float(number)
    if not seen:
        raise ModelError(
            f"{file}: no entry stands below geometric_calibration, farther to the right; indent "
            "the entries, or leave the file out"
        )
    return set_origins(text, {name: Origin.of(row) for name, row in origins.items()})


def read_block(file: str | Path | None) -> re.Match[str]:
    """Return the line above the entries of a file's text; of None, of a text without entries.

    Raises:
        ModelError: The file cannot be read, or has no such line.
    """
    try:
        text = _EMPTY
        if file:
            lines = read_bytes(file, LARGEST_DOCUMENT).decode("utf-8-sig").splitlines()
            text = "".join(f"{line}\n" for line in lines)
    except (OSError, ValueError) as error:
        raise ModelError(f"{file}: {reason_of(error)}") from None
    block = _BLOCK.search(text)
    if block is None:
        raise ModelError(
            f"{file}: no geometric_calibration with an entry a line; give the robot's {ON_ROBOT}"
        )
    return block


def _lines(file: str) -> Iterator[tuple[str, str]]:
    """Yield the lines below the block's title, without comments, each behind its place."""
    block = read_block(file)
    above, below = block.string[: block.end()], block.string[block.end() :]
    for number, line in enumerate(below.splitlines(), above.count("\n") + 1):
        entry = line.partition("#")[0].strip()
        if entry and line.index(entry) <= len(block[1]):
            return
        if entry:
            yield f"{file}:{number}", entry
