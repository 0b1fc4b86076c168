"""The full model as C99 source that needs nothing but <math.h>, for controllers.

Each function's body is what CasADi generates of the model's own expressions
(:class:`~mukca.solver.robot.PoseModel`): straight arithmetic, no loop, no memory beyond the stack.
The inverse, ``command``, is a short loop round one of them; it and the header are in ``templates``.
"""

import json
import re
from pathlib import Path
from typing import Any

import casadi as ca
from jinja2 import Environment, FileSystemLoader

from ...solver.robot import PoseModel, moments_function
from .request import Exported, ExportError, Request

_BODY = re.compile(r"static int \w+\(const casadi_real\*\* arg.*?\) \{\n(.*?)  return 0;\n\}", re.S)
_KEYWORDS = {"auto", "double", "float", "int", "long", "short", "static", "void", "const", "class"}


def write(request: Request) -> Exported:
    """Return the C file, and the header that declares what is in it."""
    file = request.file
    request.require_ending(".c")
    name = file.stem
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or name in _KEYWORDS:
        raise ExportError(
            f"--out {file}: its functions are named after it, so name it like one, as in panda.c"
        )
    calibrated = request.calibration.calibrated
    model, load = calibrated.pose_model, calibrated.load
    moments = moments_function(calibrated.robot, load.gravity, load.payload)(model.q)
    place = _flange(request)
    flange = calibrated.robot.joints[place].child
    values = {
        "ball": model.ball,
        "flange": ca.vec(model.pose(place).T),  # row after row
        "jacobian": ca.vec(model.jacobian(place).T),
        "true_positions": model.true_positions,
        "gravity": moments[: len(calibrated.robot.actuated)],
    }
    sizes = {"ball": "3", "flange": "16", "jacobian": f"6 * {name.upper()}_JOINTS"}
    functions = {word: (sizes.get(word), _body(model, value)) for word, value in values.items()}
    source = _filled(
        "controller.c.j2",
        request,
        ["The header says what each function does."],
        names=", ".join(map(json.dumps, calibrated.robot.joint_names)),
        squares=any("square(" in body for _, body in functions.values()),
        functions=functions,
    )
    header = _filled(
        "controller.h.j2",
        request,
        [
            f"Corrections of the joints: {', '.join(calibrated.deflection.extensions) or 'none'}.",
            "No function allocates memory or keeps any; all may be called from several threads.",
        ],
        number=len(calibrated.robot.actuated),
        base=_plain(calibrated.robot.base),
        flange=_plain(flange),
    )
    usage = f"Compile {name}.c with your program, include {name}.h; the flange is {flange}."
    return Exported({f"{name}.c": source, f"{name}.h": header}, (), (usage,))


def _flange(request: Request) -> int:
    """Return the chain's joint whose child link is the flange."""
    robot = request.calibration.robot
    links = [joint.child for joint in robot.joints]
    if request.flange not in links:
        raise ExportError(
            f"--flange {request.flange}: no link of the chain from {robot.base!r}; they are: "
            f"{', '.join(links)}"
        )
    return links.index(request.flange)


def _body(model: PoseModel, value: Any) -> str:
    """Return the statements of C that compute an expression of ``q`` into ``out``."""
    function = ca.Function("model", [model.q], [ca.densify(value)], {"cse": True})
    generator = ca.CodeGenerator("model", {"casadi_int": "int"})
    generator.add(function)
    match = _BODY.search(generator.dump())
    assert match is not None
    text = re.sub(r"arg\[0\]\? arg\[0\]\[(\d+)\] : 0", r"q[\1]", match[1])
    text = re.sub(r"if \(res\[0\]!=0\) res\[0\]\[(\d+)\]=", r"out[\1]=", text)
    text = text.replace("casadi_real", "double").replace("casadi_sq(", "square(")
    assert not re.search(r"casadi|\barg\b|\bres\b|\bw\[", text), "a construct of another kind"
    return text


def _filled(template: str, request: Request, about: list[str], **words: object) -> bytes:
    """Return a template's text; what stands in comments cannot end them."""
    folder = FileSystemLoader(Path(__file__).parent / "templates")
    environment = Environment(  # noqa: S701 (C, not HTML)
        loader=folder, keep_trailing_newline=True, trim_blocks=True
    )
    name = request.file.stem
    lines = [_plain(line) for line in [*request.identity.lines(), *about]]
    names = {"arm": name, "ARM": name.upper()}
    return environment.get_template(template).render(about=lines, **names, **words).encode()


def _plain(name: str) -> str:
    """Return a name as it may stand in a comment."""
    return name.replace("*/", "")
