"""Covariances of the flange's pose and of its movements, as C99 source.

With J the derivatives of the pose by the unknowns u, and F F^T their covariance, that of the pose
is J F (J F)^T and the noise of held-out samples, as in :func:`.pose_covariances`. Error curves have
thousands of unknowns: in their place u has the curves' values every 10 degrees, between which they
are interpolated; what their variance lacks there counts as noise of the joint.
"""

from functools import partial
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ...solver.calibration import POSES_AROUND
from ...solver.identification.effects import KNOTS, splines
from ...solver.identification.inference import Posterior
from ...solver.identification.model import Deflection
from ...solver.identification.robot import (
    COMPONENTS,
    workspace,
)
from ...solver.poses import PoseModel
from ...solver.results import PosedRobot, moments_function, symbolic_positions
from ...solver.studies import base_turn, covariance_of
from .c_code import flange_joint, name_of_functions, statements
from .request import Exported, ExportError, Request, filled, plain

GRID = 36
"""Angles in a turn at which the covariance of error curves is kept."""
TINY = float(np.finfo(np.float32).tiny)
"""Least number of single precision; compilers warn of smaller ones."""


class Tables(NamedTuple):
    """The numbers of the C file."""

    factor: np.ndarray
    """F, lower triangular, of the unknowns, the curves' values, and the turn of the base."""
    variances: np.ndarray
    """Of each joint's curve at each degree, shape (m, KNOTS) [rad^2]; no row without curves."""


def write(request: Request) -> Exported:
    """Return the C file, and the header that declares what is in it."""
    name = name_of_functions(request)
    calibration = request.calibration
    if calibration.document.posterior is None:
        raise ExportError(
            f"--to {request.format}: the calibration holds no covariance; solve by --method auto"
        )
    calibrated = request.kinematics.calibrated
    posterior = calibration.posterior
    robot = calibrated.robot
    of_ball = request.flange == robot.tip
    parameters = enumerate(posterior.model.parameters)
    unknowns = [i for i, p in parameters if of_ball or not p.of_ball]
    unknowns += range(posterior.model.geometry, posterior.model.scalars)
    around = calibrated.load.at(robot, workspace(robot, POSES_AROUND))
    tables = _tables(posterior, unknowns, base_turn(posterior, around))
    q, slopes = _slopes(posterior, calibrated, flange_joint(request), unknowns)
    noise = posterior.noise
    share = calibration.misfit**2 / noise.information
    size = len(tables.factor)
    words = {
        "about": request.identity.lines(),
        "arm": name,
        "number": len(robot.actuated),
        "scalars": len(unknowns),
        "grid": GRID if len(tables.variances) else 0,
        "knots": KNOTS,
        "size": size,
        "factor": [_listed(row[: i + 1]) for i, row in enumerate(tables.factor)],
        "variances": [_listed(row) for row in tables.variances],
        "slopes": statements({"q": q}, slopes),
        "space": f"{share * noise.space**2:.9g}",
        "joint": f"{share * noise.joint**2:.9g}",
        "tail": f"{calibration.tail:.3g}",
        "base": plain(robot.base),
        "flange": plain(request.flange),
    }
    files = {
        f"{name}.{ending}": filled(f"deviation.{ending}.j2", **words)
        for ending in ("c", "h")
    }
    numbers = size * (size + 1) // 2 + tables.variances.size
    line = (
        f"{name}.c holds {numbers} numbers of single precision; it needs no other file."
    )
    return Exported(files, (), (line,))


def _listed(numbers: np.ndarray) -> str:
    return ", ".join(
        f"{number:.8g}f" if abs(number) > TINY else "0" for number in numbers
    )


def _tables(posterior: Posterior, unknowns: list[int], turn: np.ndarray) -> Tables:
    """Return the tables; ``turn`` is that of the base by all unknowns, shape (3, size)."""
    Sigma = covariance_of(posterior)
    rows = np.eye(len(Sigma))[unknowns]
    variances = np.zeros((0, KNOTS))
    if posterior.deflection.curves is not None:
        scalars = posterior.model.scalars
        m = len(posterior.model.robot.actuated)
        curves = Sigma[scalars:, scalars:].reshape(KNOTS, m, KNOTS, m)
        at_knots = _values(KNOTS)
        of_joints = curves.diagonal(axis1=1, axis2=3)
        variances = np.einsum("ak,klj,al->ja", at_knots, of_joints, at_knots)
        values = np.kron(np.eye(m), _values(GRID))
        by_knot = values.reshape(-1, m, KNOTS).swapaxes(1, 2)
        of_grid = np.zeros((m * GRID, len(Sigma)))
        of_grid[:, scalars:] = by_knot.reshape(m * GRID, -1)
        rows = np.concatenate([rows, of_grid])
    rows = np.concatenate([rows, turn])
    covariance = rows @ Sigma @ rows.T
    return Tables(_triangular(covariance), variances)


def _values(count: int) -> np.ndarray:
    """Return a curve's values at so many angles by its coefficients, shape (count, KNOTS)."""
    knots, weights = splines(np.arange(count) * 2 * np.pi / count)
    values = np.zeros((count, KNOTS))
    np.put_along_axis(values, knots, weights, axis=1)
    return values


def _triangular(covariance: np.ndarray) -> np.ndarray:
    """Return F, lower triangular, whose F F^T is a covariance, which may be singular."""
    deviations = np.sqrt(np.diag(covariance))
    scale = np.where(deviations > 0, deviations, 1.0)
    correlation = covariance / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(correlation)
    root = vectors * np.sqrt(values.clip(min=0.0))
    R: np.ndarray = np.linalg.qr(root.T)[1]
    return scale[:, None] * R.T


def _slopes(
    posterior: Posterior, calibrated: PosedRobot, place: int, unknowns: list[int]
) -> tuple[Any, Any]:
    """Return q, and the flange's derivatives by unknowns and joints, and its place, by rows.

    Error curves shift the joints by milliradians, which changes no derivative to speak of.
    """
    robot, load = posterior.model.robot, calibrated.load
    m = len(robot.actuated)
    deflection = posterior.deflection.without_curves
    numbers = np.concatenate([np.zeros(0), *deflection.coefficients])
    c = ca.SX.sym("c", len(numbers))
    ends = np.cumsum([len(part) for part in deflection.coefficients])
    row = np.array(c.elements(), dtype=object)
    by_effect = np.split(row, ends[:-1])
    symbols = Deflection(deflection.extensions, tuple(by_effect))
    correct = partial(symbolic_positions, robot, symbols, load)
    origins = posterior.model.ball.origins(posterior.values)
    model = PoseModel.of(robot, origins, correct if len(numbers) else None)
    _, point = model.frames[place]
    by_corrected = model.by_corrected(place, point)
    by_geometry = _by_geometry(posterior, model, place, point)
    by_effects = by_corrected @ ca.jacobian(model.corrected, c)
    by_all = ca.horzcat(*by_geometry, by_effects)
    J = by_all[:, unknowns]
    J_q = by_corrected[:, :m]
    moments = moments_function(robot, load.gravity, load.payload)
    for effect in deflection.effects:
        if effect.joint_noise:
            # Noise of each joint's angle, as a share of its usual one.
            of_joints = np.array(moments(model.q)[:m].elements(), dtype=object)
            J_q = J_q @ ca.diag(ca.vertcat(*effect.joint_noise(of_joints)))
    slopes = ca.horzcat(J, J_q)
    rows = ca.vertcat(ca.vec(slopes.T), point)
    return model.q, ca.substitute(rows, c, ca.DM(numbers))


def _by_geometry(
    posterior: Posterior, model: PoseModel, place: int, point: Any
) -> list[Any]:
    """Return the derivatives of a link's pose by each number of the geometry, shape (6,) each."""
    frames = posterior.model.ball.frames(posterior.values)
    links = [(ca.DM.eye(3), ca.DM.zeros(3)), *model.frames]
    columns: list[Any] = []
    for parameter in posterior.model.parameters:
        i, component = divmod(parameter.index, len(COMPONENTS))
        frame = frames[i]
        R, p = links[i]
        column = ca.SX.zeros(6)
        if i <= place and component < 3:
            column[:3] = R[:, component]
        elif i <= place:
            turn = R @ ca.DM(frame[:, 1 + component])
            origin = p + R @ ca.DM(frame[:, 0])
            shift = ca.cross(turn, point - origin)
            column = ca.vertcat(shift, turn)
        columns.append(column)
    return columns
