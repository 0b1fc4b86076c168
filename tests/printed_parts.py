"""The parts that the tests look at: defaults and extremes, each built once a process."""

from functools import cache

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

BASES: dict[str, SocketBase] = {
    "default": SocketBase(),
    "nearest": SocketBase(distance=36),
    "long": SocketBase(distance=120),
    "longest": SocketBase(distance=152),
    "three": SocketBase(sockets=3),
    "three nearest": SocketBase(sockets=3, distance=46),
    "three farthest": SocketBase(sockets=3, distance=152),
    "small ball": SocketBase(distance=26, ball=10),
    "three small balls": SocketBase(distance=46, ball=10, sockets=3),
    "large ball": SocketBase(distance=56, ball=40),
    "three large balls": SocketBase(distance=120, ball=40, sockets=3),
    "tight": SocketBase(clearance=0.3),
    "loose": SocketBase(clearance=1.0),
    "low": SocketBase(height=23),
    "high": SocketBase(height=60),
    "anchored": AnchoredBase(arm="so101", width=80, front=45),
    "odd": SocketBase(distance=61.803, ball=19.05, clearance=0.37, height=33.3),
}

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
