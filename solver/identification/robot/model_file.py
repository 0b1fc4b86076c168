"""Models as users name them: a robot that comes with the package, a URDF, or one with changes.

``arm.urdf+master_calibration.yaml`` is a URDF with PAL's ``geometric_calibration`` added to it, see
:func:`.geometric_calibration.added`.
"""

from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path

from ....errors import LARGEST_DOCUMENT, read_bytes
from .chain import find_root, require_link
from .geometric_calibration import added
from .urdf import (
    BALL_LINK,
    Robot,
    parse_robot,
    shipped_robots,
    three_numbers,
    urdf_of,
)
from .urdf_edits import add_link
from .urdf_text import ModelError, Origin, UrdfText, scan

OWN_BALL = "printed_ball"
"""Link of a ball that the user puts on a model that has one already."""


def load_robot(
    robot: str | Path,
    *,
    base: str | None = None,
    tip: str = BALL_LINK,
    flange: str | None = None,
    ball: Sequence[float] | None = None,
) -> Robot:
    """Read a robot: one that comes with the package, or a URDF file.

    Args:
        robot: Name of a shipped robot, such as ``panda``, or path of a URDF file; behind a ``+``
            the path of a ``geometric_calibration``, to be added.
        base: The base link; None for the model's root.
        tip: The link whose origin is the ball's centre.
        flange: For a ball of one's own: the link that carries it. A new link, with the name
            ``tip``, is then fixed to that one; where the model has a ``ball_link`` already, it is
            called ``printed_ball``.
        ball: With ``flange``: the ball's centre in that link's frame, x y z [m]; None for one that
            an instrument measures, which is found wherever it sits.

    Raises:
        ModelError: No such robot or link, the file is not a URDF with such a chain, or ``ball`` is
            there without ``flange``.
    """
    if flange is None and ball is not None:
        raise ModelError("ball without flange: name the link that carries it")
    text = nominal_text(str(robot))
    centre = None if ball is None else three_numbers(ball, "ball")
    if flange is not None:
        tip = OWN_BALL if tip == BALL_LINK and tip in text.links else tip
        text = _with_ball(text, flange, Origin(centre or (0.0, 0.0, 0.0)), tip)
    find_root(text)  # it is a tree
    if tip not in text.links:
        require_link(text, tip, _advice(text))
    loaded = parse_robot(text, base=base, tip=tip)
    place = None if centre is None else list(centre)
    loaded_with = {"base": base, "tip": tip, "flange": flange, "ball": place}
    return replace(loaded, loaded_with=loaded_with)


def from_folder(source: str, folder: Path) -> str:
    """Return a model's source with its files as a folder has them, if it has all of them."""
    files = [folder / part for part in source.split("+")]
    found = all(file.is_file() for file in files)
    return "+".join(map(str, files)) if found else source


def nominal_text(source: str) -> UrdfText:
    """Return the URDF of a model's source, with the file that is added to it.

    Raises:
        ModelError: As by :func:`load_robot`.
    """
    name = urdf_of(source)
    text = scan(_model(name), source)
    if name != source:
        changed = added(text, source.removeprefix(f"{name}+"))
        return scan(changed, source)
    return text


def _model(name: str) -> bytes:
    """Return the URDF of a robot that comes with the package, or of a file."""
    shipped = shipped_robots()
    try:
        return read_bytes(shipped.get(name, Path(name)), LARGEST_DOCUMENT)
    except (OSError, ValueError) as error:
        # ValueError: a path with a zero
        reason = getattr(error, "strerror", None) or "cannot be read"
        similar = get_close_matches(name.lower(), shipped, n=1)
        question = f", did you mean {similar[0]!r}?" if similar else ""
        raise ModelError(
            f"robot {name!r}: {reason}{question}; give the path of a URDF file, or one of: "
            f"{', '.join(shipped)}"
        ) from None


def _with_ball(
    text: UrdfText,
    flange: str,
    origin: Origin,
    link: str,
) -> UrdfText:
    """Return a model with a ball of one's own on a link."""
    require_link(text, flange)
    try:
        data = add_link(text, flange, origin, link)
        return scan(data, text.source)
    except ModelError as error:
        raise ModelError(
            f"{error}; leave out --flange, or give the new ball another name, as in "
            "--tip printed_ball"
        ) from None


def _advice(text: UrdfText) -> str:
    """Return how to name the ball's link, with a link behind the most joints that turn."""
    ranks = _ranks(text)
    flange = max(reversed([*text.links]), key=ranks.__getitem__)
    return (
        f"; name the link that carries the ball or reflector, as in --flange {flange} --ball X Y Z "
        "(of measured points leave --ball out), or the link at its centre by --tip"
    )


def _ranks(text: UrdfText) -> dict[str, tuple[int, int]]:
    """Return how many joints above each link turn, and less how many slide, as fingers do."""
    ranks = {find_root(text): (0, 0)}
    for link in text.links:
        chain: list[str] = []
        while link not in ranks:
            chain.append(link)
            _, link = text.parents[link]
        turning, sliding = ranks[link]
        for child in reversed(chain):
            joint, _ = text.parents[child]
            kind = text.joints[joint].attributes.get("type", "")
            turning += kind not in ("fixed", "prismatic")
            sliding -= kind == "prismatic"
            ranks[child] = turning, sliding
    return ranks
