"""The full model as C99 source that needs nothing but <math.h>, for controllers.

Bodies of functions are what CasADi generates of the model's own expressions, straight arithmetic;
the inverses are short loops round one of them, in ``templates``.
"""

import re
from dataclasses import replace
from typing import Any

import casadi as ca

from ...solver import poses
from ...solver.identification.robot import Robot
from ...solver.poses import PoseModel, limited_step, newton_step
from ...solver.results import PosedRobot, moments_function
from .request import Exported, ExportError, Request, filled, plain

_BODY = re.compile(
    r"static int \w+\(const casadi_real\*\* arg.*?\) \{\n(.*?)  return 0;\n\}", re.S
)
NUMBERS = "ROUNDS STUCK NEAR LAST TINY AWAY MARGIN TOLERANCE SETTLED STILL SHORTEST"
"""Of the inverse kinematics, as :mod:`mukca.solver.poses` has them."""
FAR = 1e9
"""A limit for joints without one [rad, m]."""
_NAME = re.compile(
    r"(?!(?:auto|double|float|int|long|short|static|void|const|class)$)[A-Za-z]\w*",
    re.ASCII,
)
"""A name that is no keyword of C."""


def write(request: Request) -> Exported:
    """Return the C file, and the header that declares what is in it."""
    name = name_of_functions(request)
    calibrated = request.kinematics.calibrated
    files = {
        f"{name}.c": _source(request, calibrated),
        f"{name}.h": _header(request, calibrated),
    }
    usage = f"Compile {name}.c with your program, include {name}.h; the flange is {request.flange}."
    return Exported(files, lines=(usage,))


def name_of_functions(request: Request) -> str:
    """Return the file's name, after which functions of C are named; refuse what is none."""
    name = request.file.stem
    if not _NAME.fullmatch(name):
        raise ExportError(
            f"--out {request.file}: its functions are named after it, so name it like one, as in "
            f"panda{request.file.suffix}"
        )
    return name


def _source(request: Request, calibrated: PosedRobot) -> bytes:
    """Return the C file."""
    robot, load = calibrated.robot, calibrated.load
    model, d, dd = _with_curves(calibrated)
    moments = moments_function(robot, load.gravity, load.payload)(model.q)
    place = flange_joint(request)
    rigid = PoseModel.of(robot, calibrated.origins)
    values = {
        "ball": model.ball,
        "flange": ca.vec(model.pose(place).T),  # row after row
        "jacobian": ca.vec(_jacobian(model, place, d, dd).T),
        "true_positions": model.true_positions,
        "gravity": moments[: len(robot.actuated)],
    }
    joints = f"{request.file.stem.upper()}_JOINTS"
    sizes = {"ball": "3", "flange": "16", "jacobian": f"6 * {joints}"}
    q = {"q": model.q, "d": d, "dd": dd}
    bodies = {word: statements(q, value) for word, value in values.items()}
    arguments, value = _step(model, place, robot)
    step = statements({**arguments, "d": d}, value)
    curves = calibrated.deflection.curves
    limits = [", ".join(map("{:.17g}".format, side)) for side in _limits(robot)]
    return _filled(
        "controller.c.j2",
        request,
        ["The header says what each function does."],
        urdf_flange=statements({"q": rigid.q}, ca.vec(rigid.pose(place).T)),
        number=len(robot.actuated),
        curves=None if curves is None else curves.T.tolist(),
        curved=[word for word, value in values.items() if ca.depends_on(value, d)],
        names=", ".join(map(literal, robot.joint_names)),
        step=step,
        LAST=f"{calibrated.last_step:g}",
        limits=limits,
        squares=any("square(" in body for body in (step, *bodies.values())),
        functions={word: (sizes.get(word), body) for word, body in bodies.items()},
    )


def _header(request: Request, calibrated: PosedRobot) -> bytes:
    """Return the header."""
    robot = calibrated.robot
    carried = robot.bodies[len(request.robot.bodies) :]
    mass = sum(body.mass for body in carried) + calibrated.load.payload
    corrections = ", ".join(calibrated.deflection.extensions) or "none"
    return _filled(
        "controller.h.j2",
        request,
        [
            f"Corrections of the joints: {corrections}.",
            f"Mass carried beyond the URDF's: {mass:g} kg.",
            "No function allocates memory or keeps any; all may be called from several threads.",
        ],
        number=len(robot.actuated),
        base=plain(robot.base),
        flange=plain(request.flange),
    )


def _with_curves(calibrated: PosedRobot) -> tuple[PoseModel, Any, Any]:
    """Return the model with symbols for its error curves' values and slopes at q, and these."""
    m = len(calibrated.robot.actuated)
    deflection = calibrated.deflection
    d = ca.SX.sym("d", m)
    dd = ca.SX.sym("dd", m)
    if deflection.curves is None:
        return calibrated.pose_model, d, dd
    model = replace(calibrated, deflection=deflection.without_curves).pose_model

    def correct(q: Any) -> Any:
        true = ca.substitute(model.corrected, model.q, q)
        return ca.vertcat(true[:m] + d, true[m:])

    origins = calibrated.model.origins(calibrated.values)
    return PoseModel.of(calibrated.robot, origins, correct), d, dd


def _jacobian(model: PoseModel, joint: int, d: Any, dd: Any) -> Any:
    """Return :meth:`.PoseModel.jacobian`, by the curves of such values and slopes, too."""
    by_curves: Any = ca.jacobian(model.corrected, d) @ ca.diag(dd)
    by_reading = ca.jacobian(model.corrected, model.q) + by_curves
    return ca.densify(model.by_corrected(joint, model.frames[joint][1]) @ by_reading)


def flange_joint(request: Request) -> int:
    """Return the chain's joint whose child link is the flange."""
    robot = request.robot
    links = [joint.child for joint in robot.joints]
    if request.flange not in links:
        raise ExportError(
            f"--flange {request.flange}: no link of the chain from {robot.base!r}; they are: "
            f"{', '.join(links)}"
        )
    return links.index(request.flange)


def literal(text: str) -> str:
    """Return a text as a string of C: UTF-8, and octal what C could read otherwise."""
    letters = text.encode().decode("latin-1")  # a letter for each byte
    safe = re.sub(r'[^ -~]|["\\?]', lambda match: f"\\{ord(match[0]):03o}", letters)
    return f'"{safe}"'


def _limits(robot: Robot) -> tuple[list[float], list[float]]:
    """Return the limits of the joints as C can write them."""
    lower = robot.lower.clip(min=-FAR)
    return lower.tolist(), robot.upper.clip(max=FAR).tolist()


def _step(model: PoseModel, place: int, robot: Robot) -> tuple[dict[str, Any], Any]:
    """Return the arguments and the value of one step of the inverse kinematics."""
    step = newton_step(model, place, "pose")
    lower, upper = map(ca.DM, _limits(robot))
    margin = ca.SX.sym("away")
    change = limited_step(step, lower + margin, upper - margin)
    moved = ca.vertcat(step.left, change)
    value = ca.substitute(moved, step.symbols["tool"], ca.DM(poses.NO_TOOL))
    arguments = {name: step.symbols[name] for name in ("q", "target", "prefer")}
    return {**arguments, "away": margin}, value


def statements(arguments: dict[str, Any], value: Any) -> str:
    """Return the statements of C that compute an expression of named arguments into ``out``."""
    outputs = [ca.densify(value)]
    function = ca.Function("model", [*arguments.values()], outputs, {"cse": True})
    generator = ca.CodeGenerator("model", {"casadi_int": "int"})
    generator.add(function)
    match = _BODY.search(generator.dump())
    assert match
    text = match[1]
    for i, name in enumerate(arguments):
        text = re.sub(rf"arg\[{i}\]\? arg\[{i}\]\[(\d+)\] : 0", rf"{name}[\1]", text)
    text = re.sub(r"if \(res\[0\]!=0\) res\[0\]\[(\d+)\]=", r"out[\1]=", text)
    text = text.replace("casadi_real", "double").replace("casadi_sq(", "square(")
    text = text.replace("casadi_fmin(", "fmin(").replace("casadi_fmax(", "fmax(")
    assert not re.search(r"casadi|\barg\b|\bres\b|\bw\[", text), (
        "a construct of another kind"
    )
    return text


def _filled(
    template: str, request: Request, about: list[str], **words: object
) -> bytes:
    """Return a template's text; what stands in comments cannot end them."""
    lines = [*request.identity.lines(), *map(plain, about)]
    numbers = {word: f"{getattr(poses, word):g}" for word in NUMBERS.split()}
    names = {"arm": request.file.stem, "about": lines}
    return filled(template, **(names | numbers | words))
