"""The full model as C99 source that needs nothing but <math.h>, for controllers.

Each function's body is what CasADi generates of the model's own expressions
(:mod:`mukca.tools.export.expressions`): straight arithmetic, no loop, no memory beyond the stack.
Its
inverse, ``command``, is a short loop round one of them.
"""

import json
import re
from string import Template
from typing import Any

import casadi as ca

from .expressions import FullModel, full_model
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
    model = full_model(calibrated)
    place = _flange(request)
    flange = calibrated.robot.joints[place].child
    values = {
        "ball": model.ball,
        "flange": ca.vec(model.pose(place).T),  # row after row
        "jacobian": ca.vec(model.jacobian(place).T),
        "true_positions": model.true_positions,
        "gravity": model.gravity,
    }
    bodies = {word: _body(model, value) for word, value in values.items()}
    source = _source(request, bodies)
    header = _header(request, flange)
    usage = f"Compile {name}.c with your program, include {name}.h; the flange is {flange}."
    return Exported({f"{name}.c": source.encode(), f"{name}.h": header.encode()}, (), (usage,))


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


def _body(model: FullModel, value: Any) -> str:
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


def _header(request: Request, flange: str) -> str:
    """Return the declarations, each with what it does."""
    robot = request.calibration.robot
    extensions = request.calibration.calibrated.deflection.extensions
    about = [
        *request.identity.lines(),
        f"Corrections of the joints: {', '.join(extensions) or 'none'}.",
        "No function allocates memory or keeps any; all may be called from several threads.",
    ]
    words = {"number": len(robot.actuated), "base": _plain(robot.base), "flange": _plain(flange)}
    return _comment(about) + _filled(_HEADER, request, **words)


def _plain(name: str) -> str:
    """Return a name as it may stand in a comment."""
    return name.replace("*/", "")


def _comment(lines: list[str]) -> str:
    return "/* " + "\n   ".join(map(_plain, lines)) + " */\n"


def _filled(template: str, request: Request, **words: object) -> str:
    name = request.file.stem
    return Template(template).substitute(arm=name, ARM=name.upper(), **words)


def _source(request: Request, bodies: dict[str, str]) -> str:
    joints = request.calibration.robot.joint_names
    parts = [
        _comment([*request.identity.lines(), "The header says what each function does."]),
        f'#include "{request.file.stem}.h"\n\n#include <math.h>\n',
        _filled(_NAMES, request, names=", ".join(map(json.dumps, joints))),
    ]
    if any("square(" in body for body in bodies.values()):
        parts.append("static double square(double x) { return x * x; }\n")
    sizes = {"ball": "3", "flange": "16", "jacobian": "6 * ${ARM}_JOINTS"}
    for word, body in bodies.items():
        size = sizes.get(word, "${ARM}_JOINTS")
        declared = f"void ${{arm}}_{word}(const double q[${{ARM}}_JOINTS], double out[{size}]) {{"
        parts.append(f"{_filled(declared, request)}\n{body}}}\n")
    return "\n".join([*parts, _filled(_COMMAND, request)])


_HEADER = """
#ifndef ${ARM}_H
#define ${ARM}_H

#ifdef __cplusplus
extern "C" {
#endif

#define ${ARM}_JOINTS $number

/* The joints, in the order of every array. Positions are radians (metres for a prismatic joint),
   as the robot's encoders report them; lengths are metres. */
extern const char *const ${arm}_joint_names[${ARM}_JOINTS];

/* The calibration ball's centre in the frame of $base. */
void ${arm}_ball(const double q[${ARM}_JOINTS], double p[3]);

/* The pose of $flange in the frame of $base: a 4 x 4 matrix, row after row. */
void ${arm}_flange(const double q[${ARM}_JOINTS], double T[16]);

/* The Jacobian of $flange, a 6 x $number matrix, row after row: the joints' speeds are multiplied
   by it to give the speed of its origin, upper three rows, and its angular velocity, lower three
   rows; both in the frame of $base. */
void ${arm}_jacobian(const double q[${ARM}_JOINTS], double J[6 * ${ARM}_JOINTS]);

/* Where the joints truly are while the robot, at rest, reports q. */
void ${arm}_true_positions(const double q[${ARM}_JOINTS], double positions[${ARM}_JOINTS]);

/* The inverse: what to command so that the joints truly stand at q. Returns 0, or -1 where q is
   not a configuration; the positions are not to be used then. */
int ${arm}_command(const double q[${ARM}_JOINTS], double positions[${ARM}_JOINTS]);

/* The torques that hold the arm against gravity, by the masses of its model [N m]. */
void ${arm}_gravity(const double q[${ARM}_JOINTS], double torques[${ARM}_JOINTS]);

#ifdef __cplusplus
}
#endif
#endif
"""

_NAMES = """\
const char *const ${arm}_joint_names[${ARM}_JOINTS] = {$names};
"""

_COMMAND = """\
int ${arm}_command(const double q[${ARM}_JOINTS], double positions[${ARM}_JOINTS]) {
  double there[${ARM}_JOINTS];
  int i, round, done = 0;
  for (i = 0; i < ${ARM}_JOINTS; ++i) positions[i] = q[i];
  /* Each round leaves a thousandth of the error: joints are corrected by milliradians. */
  for (round = 0; round < 20 && !done; ++round) {
    ${arm}_true_positions(positions, there);
    done = 1;
    for (i = 0; i < ${ARM}_JOINTS; ++i) {
      const double miss = q[i] - there[i];
      if (!(fabs(miss) <= 1e-14)) done = 0;
      positions[i] += miss;
    }
  }
  return done ? 0 : -1;
}
"""
