"""The ``geometric_calibration`` of PAL Robotics' robots, which their robot_state_publisher adds.

Each entry, as ``arm_1_dx`` of ``arm_1_joint``, is added to a number of the joint's URDF origin:
dx, dy, dz [m] to ``xyz``, and droll, dpitch, dyaw [rad] to ``rpy`` as it is written there.
"""

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress

from ...solver.identification.robot import (
    COMPONENTS,
    ON_ROBOT,
    ModelError,
    Origin,
    nominal_text,
    read_block,
    urdf_of,
)
from .request import (
    Exported,
    ExportError,
    Request,
    after_last_exported,
    exported,
    redistributed_origins,
)

_JOINT = re.compile(r"(?:arm|head|leg|torso)_(?:\w+_)?(?:\d|lift)_joint$")


def write(request: Request) -> Exported:
    """Return the file; of the one that ``--like`` names, what is of other joints stays."""
    joints = {joint.name: joint for joint in request.robot.actuated}
    strangers = [name for name in joints if not _JOINT.match(name)]
    if strangers:
        raise ExportError(
            f"--to pal: {', '.join(strangers)}: not named like the joints of a robot of PAL "
            "Robotics, arm_1_joint, ..; --to xacro works for any arm"
        )
    entries: list[str] = []
    nominal = _urdf_origins(request)
    for name, origin in redistributed_origins(request, joints).items():
        key = name.removesuffix("_joint")
        changes = (origin - nominal[name].numbers).tolist()
        entries += [
            f"{key}_d{component}: {change:.17f}"
            for component, change in zip(COMPONENTS, changes, strict=True)
            if change
        ]
    text = _merged(read_block(request.like), list(joints), entries)
    about = "".join(f"# {line}\n" for line in request.identity.lines())
    lines = (
        f"Copy it to {ON_ROBOT}, and start robot_state_publisher again.",
        "Its entries are added to the URDF that was calibrated, without any "
        "geometric_calibration.",
    )
    held = after_last_exported(request, joints)
    return exported(request, (about + text).encode(), lines, held)


def _urdf_origins(request: Request) -> Mapping[str, Origin]:
    """Return the origins to which the robot adds: a URDF's without what ``--robot`` added to it.

    Raises:
        ExportError: The files are not there, or are others than those that were calibrated.
    """
    robot = request.robot
    file = urdf_of(robot.source)
    if file == robot.source:
        return robot.text.origins
    with suppress(ModelError):
        added = nominal_text(robot.source).origins
        if added.items() <= robot.text.origins.items():
            return nominal_text(file).origins
    raise ExportError(
        f"--to pal: {robot.source} cannot be read as it was calibrated; run this in the folder "
        "where mukca solve ran, with both files as they were then"
    )


def _merged(
    block: re.Match[str],
    joints: Sequence[str],
    entries: Sequence[str],
) -> str:
    """Return a file's text with other entries of some joints."""
    keys = "|".join(re.escape(joint.removesuffix("_joint")) for joint in joints)
    entry = rf"^[ \t]+(?:{keys})_d(?:{'|'.join(COMPONENTS)})[ \t]*:.*\n?"
    after = re.sub(entry, "", block.string[block.end() :], flags=re.M)
    others = re.match(rf"{block[1]}[ \t]+(?=\w)", after)
    margin = others[0] if others else f"{block[1]}  "
    new = "".join(f"{margin}{line}\n" for line in entries)
    return (
        f"{block.string[: block.start()]}{block[1]}geometric_calibration:\n{new}{after}"
    )
