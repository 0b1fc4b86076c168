"""Explains samples that lie outside their socket: a base that moved, a wrong socket number."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Measurement
from .change_points import Change, Part
from .diagnostic import Diagnostic, row_of
from .robust_fit import RigidFit

FAR = 0.06
"""Robust weight below which a sample is far from its socket, about 9 deviations."""
SEATED = 0.03
"""A ball that lies farther from its socket than this [m] is not just badly seated."""
LOOSE, PLAYED = 5e-4, 5e-3
"""Noise of an arm whose gears have play [m], and how far that may move a socket [m]."""
LISTED = 20
"""Samples of a placement that are named one by one."""
NEAR = 3e-3
"""Centres nearer than this [m], or ten deviations, may be those of one socket."""


@dataclass(frozen=True)
class Sockets:
    """The sockets of all placements, in order, and where a fit has them."""

    labels: tuple[tuple[str, int], ...]
    """Placement and number of each."""
    centres: np.ndarray
    """Shape (S, 3) [m]."""
    noise: float
    """Of a sample [m]."""

    def at(self, place: np.ndarray, but: int) -> int | None:
        """Return the socket at a place, other than one; None where there is none."""
        away = np.linalg.norm(self.centres - place, axis=1)
        away[but] = np.inf
        nearest = int(np.argmin(away))
        return nearest if away[nearest] < max(NEAR, 10 * self.noise) else None


def elsewhere(
    measured: Measurement,
    parts: Sequence[Part],
    fit: RigidFit,
    sockets: Sockets,
    *,
    zeros: bool = False,
) -> tuple[list[Diagnostic], tuple[Change, ...]]:
    """Return what the parts of a placement's sockets are, and where its base moved.

    Args:
        measured: The placement.
        parts: All parts; see :func:`~mukca.solver.diagnostics.change_points.find_parts`.
        fit: To them.
        sockets: The sockets' own parts.
        zeros: Whether the arm is known to be made of servos, whose gears have play.
    """
    findings: list[Diagnostic] = []
    changes: list[Change] = []
    for index in range(len(sockets.labels), len(parts)):
        part = parts[index]
        name, socket = sockets.labels[part.socket]
        if name != measured.name:
            continue
        own, place = sockets.centres[part.socket], fit.centres[index]
        jump = float(np.linalg.norm(place - own))
        if jump < max(NEAR / 4, sockets.noise):
            continue  # the base is back where it was
        other = sockets.at(place, but=part.socket)
        if other is not None and jump > 2 * NEAR:
            findings.append(_other_socket(measured, part, socket, sockets.labels[other], jump))
            continue
        before = part.end <= parts[part.socket].begin
        change = Change(socket, part.end if before else part.begin, jump)
        changes.append(change)
        play = not zeros and explained_by_backlash(sockets, change)
        findings.append(_moved(measured, change, play=play))
    return findings, tuple(sorted(changes, key=lambda change: (change.socket, change.sample)))


def explained_by_backlash(sockets: Sockets, change: Change) -> bool:
    """Tell whether gears with play would look like this move of the base, too."""
    return sockets.noise > LOOSE and change.jump < PLAYED


def _moved(measured: Measurement, change: Change, *, play: bool) -> Diagnostic:
    advice = "record it again, or keep both parts by --split-moved"
    if play:
        advice += "; or it is play: for an arm made of servos say --zeros, by --method auto"
    return Diagnostic(
        "error",
        "moved",
        row_of(measured, change.socket, change.sample),
        f"the base moved by {1e3 * change.jump:.1f} mm before sample {change.sample + 1} of "
        f"socket {change.socket}",
        advice,
    )


def _other_socket(
    measured: Measurement, part: Part, socket: int, label: tuple[str, int], jump: float
) -> Diagnostic:
    where = row_of(measured, socket, part.begin)
    samples = f"samples {part.begin + 1} to {part.end} of socket {socket}"
    name, number = label
    if name == measured.name:
        text = f"{samples} lie in socket {number}, {1e3 * jump:.1f} mm from the others"
        advice = "a wrong socket number: mend it, or delete them"
    else:
        text = f"{samples} lie in socket {number} of {name}, {1e3 * jump:.1f} mm from the others"
        advice = "they were recorded with the base there: move them, or delete them"
    return Diagnostic("error", "mislabelled", where, text, advice)


def far_samples(
    measured: Measurement, parts: Sequence[Part], alone: RigidFit, together: Sockets
) -> list[Diagnostic]:
    """Return samples that lie far from the others of their socket.

    Args:
        measured: The placement.
        parts: Its own parts.
        alone: The fit to them alone.
        together: The sockets of all placements, for the scale of the noise.
    """
    own = Sockets(
        tuple((measured.name, socket) for socket in measured.sockets),
        alone.centres[: len(measured.sockets)],
        max(alone.noise, together.noise),
    )
    findings: list[Diagnostic] = []
    for row in np.flatnonzero(alone.weights < FAR)[:LISTED].tolist():
        part = parts[int(alone.samples.sockets[row])]
        sample = row - measured.slices[part.socket].start
        socket = measured.sockets[part.socket]
        where = row_of(measured, socket, sample)
        error = float(alone.errors[row])
        text = f"{1e3 * error:.1f} mm from socket {socket}, weight {alone.weights[row]:.3f}"
        away = np.linalg.norm(alone.points[row] - own.centres, axis=1)
        nearest = int(np.argmin(away))
        if nearest != part.socket and away[nearest] < 0.3 * error:
            other = measured.sockets[nearest]
            advice = f"it lies in socket {other}: a wrong socket number"
            findings.append(Diagnostic("error", "mislabelled", where, text, advice))
        elif error > SEATED:
            advice = "it was recorded elsewhere: another base position, or another arm; delete it"
            findings.append(Diagnostic("error", "elsewhere", where, text, advice))
        else:
            advice = "was the ball seated? It hardly counts; delete it if it was not"
            findings.append(Diagnostic("warning", "far", where, text, advice))
    return findings
