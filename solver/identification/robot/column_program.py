"""A CasADi function as calls of NumPy, each of which computes one instruction for many rows."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import casadi as ca
import numpy as np


class Instruction(NamedTuple):
    """One instruction of a CasADi function."""

    name: str
    """Empty for one that NumPy does not know."""
    into: list[int]
    """Index of the number that it writes; of an output, its index and the row in it."""
    operands: list[int]
    """Indices of the numbers that it reads; of an input, its index and the row in it."""


def instructions_of(function: Any) -> list[Instruction]:
    """Return the instructions of a CasADi function."""
    instructions: list[Instruction] = []
    for k in range(function.n_instructions()):
        name = _NAMES.get(function.instruction_id(k), "")
        into = function.instruction_output(k)
        operands = function.instruction_input(k)
        instructions.append(Instruction(name, into, operands))
    return instructions


@dataclass
class ColumnProgram:
    """Calls of NumPy, and the columns that they read and write, a row of values each."""

    inputs: list[np.ndarray]
    """Columns of each input, shape (numbers, rows)."""
    outputs: list[np.ndarray]
    """Columns of each output, shape (numbers, rows)."""
    work: np.ndarray
    """Columns of what is computed in between, shape (numbers, rows)."""
    columns: list[np.ndarray]
    """The column of each number by now: one of ``work``, an input, or a constant."""
    calls: list[tuple[Any, tuple[Any, ...]]] = field(default_factory=list[Any])
    """Functions and their arguments, of which the last is written."""
    partners: dict[tuple[str, int], np.ndarray] = field(default_factory=dict[Any, Any])
    """Sines that were computed beside cosines, and the other way round, by name and angle."""

    @classmethod
    def of(
        cls,
        function: Any,
        instructions: Sequence[Instruction],
        rows: int,
    ) -> "ColumnProgram":
        """Return the program of a CasADi function for a number of rows."""
        inputs = [np.ones((function.numel_in(i), rows)) for i in range(function.n_in())]
        outputs = [
            np.ones((function.numel_out(i), rows)) for i in range(function.n_out())
        ]
        work = np.ones((function.sz_w(), rows))
        program = cls(inputs, outputs, work, [*work])
        for k, instruction in enumerate(instructions):
            if instruction.name == "CONST":
                [target] = instruction.into
                constant = np.array(function.instruction_constant(k))
                program.replace_column(target, constant)
            else:
                program.add(instruction)
        return program

    def run(self) -> None:
        """Compute the outputs of the inputs."""
        with np.errstate(all="ignore"):  # as CasADi does
            for function, arguments in self.calls:
                function(*arguments)

    def add(self, instruction: Instruction) -> None:
        """Add the call of an instruction, if it needs any."""
        name, into, operands = instruction
        if name == "OUTPUT":
            output, row = into
            [value] = operands
            target_row = self.outputs[output][row]
            self.calls.append((np.copyto, (target_row, self.columns[value])))
            return
        [target] = into
        if name == "INPUT":
            source, row = operands
            self.replace_column(target, self.inputs[source][row])
        elif name in ("SIN", "COS"):
            self._add_angle(name, operands[0], target)
        else:
            values = [self.columns[i] for i in operands]
            result = self.work[target]
            self.calls.append((_INSTRUCTIONS[name], (*values, result)))
            self.replace_column(target, result)

    def replace_column(self, target: int, column: np.ndarray) -> None:
        """Let a number be a column from now on."""
        for name in ("SIN", "COS"):
            self.partners.pop((name, target), None)
        self.columns[target] = column

    def _add_angle(
        self,
        name: str,
        operand: int,
        target: int,
    ) -> None:
        """Add the sine or cosine of an angle, and keep the other one until it is asked for."""
        partner = self.partners.get((name, operand))
        if partner is not None:
            self.replace_column(target, partner)
            return
        angle = self.columns[operand]
        result = self.work[target]
        other = np.empty_like(result)
        self.replace_column(target, result)
        if name == "SIN":
            self.calls.append((_turn, (angle, result, other)))
            partner_name = "COS"
        else:
            self.calls.append((_turn, (angle, other, result)))
            partner_name = "SIN"
        if operand != target:
            self.partners[partner_name, operand] = other


_HALF, _ONE, _TWO = map(np.array, (0.5, 1.0, 2.0))


def _turn(
    angle: np.ndarray,
    sine: np.ndarray,
    cosine: np.ndarray,
) -> None:
    """Compute both of an angle by the tangent of its half, a third of the work of NumPy's own."""
    np.multiply(angle, _HALF, sine)
    np.tan(sine, sine)
    np.square(sine, cosine)
    np.add(cosine, _ONE, cosine)
    np.divide(_TWO, cosine, cosine)
    np.multiply(sine, cosine, sine)
    np.subtract(cosine, _ONE, cosine)


def _chosen(
    condition: np.ndarray,
    value: np.ndarray,
    out: np.ndarray,
) -> None:
    """Write the value where a condition holds, zero elsewhere."""
    np.copyto(out, np.where(condition, value, 0.0))


_INSTRUCTIONS: dict[str, Any] = {
    "CONST": None,
    "INPUT": None,
    "OUTPUT": None,
    "SIN": None,
    "COS": None,
    "ADD": np.add,
    "SUB": np.subtract,
    "MUL": np.multiply,
    "DIV": np.divide,
    "NEG": np.negative,
    "SQ": np.square,
    "TWICE": partial(np.multiply, _TWO),
    "INV": np.reciprocal,
    "SQRT": np.sqrt,
    "LOG": np.log,
    "ATAN2": np.arctan2,
    "FMIN": np.fmin,
    "FMAX": np.fmax,
    "FABS": np.abs,
    "FLOOR": np.floor,
    "LT": np.less,
    "LE": np.less_equal,
    "EQ": np.equal,
    "NE": np.not_equal,
    "NOT": np.logical_not,
    "IF_ELSE_ZERO": _chosen,
}
"""NumPy's functions by the names of CasADi's instructions; None for those that have their own."""
_NAMES = {int(getattr(ca, f"OP_{name}")): name for name in _INSTRUCTIONS}
