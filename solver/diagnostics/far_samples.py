"""Check for samples far from the others of their socket, by the fit to the placement alone."""

import numpy as np

from ..data import Measurement
from .diagnostic import Diagnostic, row_of
from .evidence import Evidence

FAR = 0.06
"""Robust weight below which a sample is far from its socket, about 9 deviations."""
SEATED = 0.03
"""A ball that lies farther from its socket than this [m] is not just badly seated."""
IN_OTHER = 0.3
"""A sample lies in another socket if it is nearer to it by this factor."""
LISTED = 20
"""Samples of a placement that are named one by one."""


def far_samples(evidence: Evidence, measured: Measurement) -> list[Diagnostic]:
    """Return samples of a placement that lie far from their socket."""
    fit, segments = evidence.alone[measured.name]
    centres = fit.centres[: len(measured.sockets)]
    found: list[Diagnostic] = []
    for row in np.flatnonzero(fit.weights < FAR)[:LISTED].tolist():
        own = segments[int(fit.samples.sockets[row])].socket
        socket, error = measured.sockets[own], float(fit.errors[row])
        where = row_of(measured, socket, row - measured.slices[own].start)
        text = f"{1e3 * error:.1f} mm from socket {socket}, weight {fit.weights[row]:.3f}"
        away = np.linalg.norm(fit.points[row] - centres, axis=1)
        nearest = int(np.argmin(away))
        if nearest != own and away[nearest] < IN_OTHER * error:
            advice = f"it lies in socket {measured.sockets[nearest]}: a wrong socket number"
            found.append(Diagnostic("error", "mislabelled", where, text, advice))
        elif error > SEATED:
            advice = "it was recorded elsewhere: another base position, or another arm; delete it"
            found.append(Diagnostic("error", "elsewhere", where, text, advice))
        else:
            advice = "was the ball seated? It hardly counts; delete it if it was not"
            found.append(Diagnostic("warning", "far", where, text, advice))
    return found
