"""The parts that the tests look at: defaults and extremes, each built once a process."""

import json
from functools import cache
from pathlib import Path

from mesh_checks import load_stl

from mukca.tools.printables import (
    MOUNTS,
    AnchoredBase,
    BallPart,
    SocketBase,
    bolt_circle,
    build_parts,
    encode,
    grip,
)

SIZES = json.loads(Path(__file__).with_name("printed_bases.json").read_text())
BASES: dict[str, SocketBase] = {name: SocketBase(**size) for name, size in SIZES.items()}
BASES["anchored"] = AnchoredBase(arm="so101", width=80, front=45)

BALLS: dict[str, BallPart] = {
    **{name: BallPart(mount) for name, mount in MOUNTS.items()},
    **{f"{name} bought": BallPart(mount, bought=True) for name, mount in MOUNTS.items()},
    "thin neck": BallPart(MOUNTS["iso-50-4-m6"], neck=6),
    "thick neck": BallPart(MOUNTS["iso-50-4-m6"], neck=9.3),
    "longer": BallPart(MOUNTS["iso-50-4-m6"], reach=90),
    "smallest circle": BallPart(bolt_circle(20, 2, "M3"), ball=17),
    "largest circle": BallPart(bolt_circle(125, 12, "M8")),
    "smallest grip": BallPart(grip(8, 8, 8)),
    "largest grip": BallPart(grip(40, 40, 60)),
    "odd": BallPart(bolt_circle(41.3, 5, "M4"), ball=19.05),
}


@cache
def base(name):
    return next(build_parts(BASES[name], {}))


@cache
def ball(name):
    return made(name, BALLS[name])


def made(name, ball):
    """A ball part as it is built beside a base with room for it."""
    return list(build_parts(SocketBase(distance=120, ball=ball.ball), {name: ball}))[-1]


@cache
def base_mesh(name):
    return load_stl(encode("stl", base(name)))


@cache
def ball_mesh(name):
    return load_stl(encode("stl", ball(name)))
