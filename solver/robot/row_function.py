"""Calls CasADi functions on the rows of NumPy arrays, in whose memory they read and write.

CasADi's own call turns arrays into lists and back, which takes longer than the computation.
"""

from functools import cached_property, lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np

BATCH = 208
"""Rows that are computed at once: the results of more no longer fit into a processor's cache."""
STEP = 16
"""CasADi prepares a function for each number of rows: some rows twice cost less."""
MANY = 256
"""Rows from which on NumPy goes through the columns."""
BLOCK = 1024
"""Rows whose columns are computed at once."""


class RowFunction:
    """A CasADi function whose last argument is one row; the other arguments serve all rows.

    Its inputs are column vectors of symbols, its outputs vectors or matrices. CasADi goes through
    all instructions row by row. Of many rows, NumPy computes each instruction for all of them at
    once, in a fifth of the time. What is computed ``times`` times is each time computed of the
    output before: then there is one input, a row, and one output like it.
    """

    def __init__(
        self, name: str, inputs: list[Any], outputs: list[Any], times: int = 1
    ) -> None:
        # CasADi writes column by column, NumPy reads row by row.
        turned = [ca.densify(ca.SX(output).T) for output in outputs]
        self._sizes = [output.numel() for output in turned]
        self._lengths = [symbol.numel() for symbol in inputs]
        function = ca.Function(name, inputs, turned, {"cse": True})
        self.function = function.fold(times) if times > 1 else function
        self._mapped = lru_cache(maxsize=32)(self._map)
        self._program = lru_cache(maxsize=8)(self._instructions)

    def __call__(self, rows: np.ndarray, *constants: np.ndarray) -> list[np.ndarray]:
        """Return each output for each row, shape (N, k); the other arguments serve all rows."""
        arguments = [np.asarray(values, dtype=float) for values in (*constants, rows)]
        lengths = [values.shape[-1] for values in arguments]
        if lengths != self._lengths:  # CasADi would read beyond them
            raise ValueError(f"arguments of lengths {lengths}, not {self._lengths}")
        by_columns = len(rows) >= MANY and self._known
        return (self._by_columns if by_columns else self._by_rows)(*arguments)

    @cached_property
    def _known(self) -> bool:
        """True where NumPy knows all instructions."""
        return all(name for name, _, _ in self._steps)

    @cached_property
    def _steps(self) -> list[tuple[str, list[int], list[int]]]:
        """Each instruction's name, none for one that NumPy does not know, outputs and operands."""
        f = self.function
        names = [_NAMES.get(f.instruction_id(k), "") for k in range(f.n_instructions())]
        into = map(f.instruction_output, range(len(names)))
        operands = map(f.instruction_input, range(len(names)))
        return [*zip(names, into, operands, strict=True)]

    def _by_rows(self, *arguments: np.ndarray) -> list[np.ndarray]:
        *fixed, rows = map(np.ascontiguousarray, arguments)
        count = len(rows)
        if count > STEP and count % STEP:
            rows = np.concatenate([rows, np.repeat(rows[-1:], -count % STEP, axis=0)])
        results = [np.empty((len(rows), size)) for size in self._sizes]
        for begin in range(0, len(rows), BATCH):
            batch = slice(begin, begin + BATCH)
            mapped, idle = self._mapped(len(rows[batch]))
            try:
                buffer, run = idle.pop()
            except IndexError:  # another thread may be using it
                buffer, run = mapped.buffer()
            for i, values in enumerate((*fixed, rows[batch])):
                buffer.set_arg(i, values.data)
            for i, values in enumerate(results):
                buffer.set_res(i, values[batch].data)
            run()
            idle.append((buffer, run))
        return [values[:count] for values in results]

    def _map(self, N: int) -> tuple[Any, list[Any]]:
        """Return the function for N rows, and its buffers, each of which takes as long as a call.

        The arguments but the last are the same for each row.
        """
        shared = list(range(self.function.n_in() - 1))
        return self.function.map(
            f"{self.function.name()}_{N}", "serial", N, shared, []
        ), []

    def _by_columns(self, *arguments: np.ndarray) -> list[np.ndarray]:
        *fixed, rows = arguments
        results = [np.empty((size, len(rows))).T for size in self._sizes]
        for begin in range(0, len(rows), BLOCK):
            batch = rows[begin : begin + BLOCK]
            count = len(batch)
            program, inputs, outputs = self._program(
                max(MANY, 1 << (count - 1).bit_length())
            )
            for columns, values in zip(inputs, (*fixed, batch), strict=True):
                columns[:, :count] = np.atleast_2d(values).T
            with np.errstate(all="ignore"):  # as CasADi does
                for instruction, values in program:
                    instruction(*values)
            for columns, result in zip(outputs, results, strict=True):
                result[begin : begin + count] = columns[:, :count].T
        return results

    def _instructions(self, length: int) -> Any:
        """Return instructions with their columns of some length; inputs and outputs."""
        f = self.function
        work = np.ones((f.sz_w(), length))
        column: list[Any] = list(work)
        program: list[Any] = []
        inputs = [np.ones((size, length)) for size in self._lengths]
        outputs = [np.ones((size, length)) for size in self._sizes]
        sines: dict[tuple[str, int], np.ndarray] = {}
        for k, (name, into, operands) in enumerate(self._steps):
            if name == "OUTPUT":
                program.append(
                    (np.copyto, (outputs[into[0]][into[1]], column[operands[0]]))
                )
                continue
            angle = sines.get((name, operands[0])) if name in ("SIN", "COS") else None
            values = (
                [column[i] for i in operands] if name not in ("CONST", "INPUT") else []
            )
            for word in ("SIN", "COS"):
                sines.pop((word, into[0]), None)
            column[into[0]] = work[into[0]]
            if name == "CONST":
                column[into[0]] = np.array(f.instruction_constant(k))
            elif name == "INPUT":
                column[into[0]] = inputs[operands[0]][operands[1]]
            elif angle is not None:
                column[into[0]] = angle
            elif name in ("SIN", "COS"):
                second = np.empty(length)
                if operands[0] != into[0]:
                    sines["COS" if name == "SIN" else "SIN", operands[0]] = second
                pair = (column[into[0]], second)
                program.append(
                    (_turn, (*values, *(pair if name == "SIN" else pair[::-1])))
                )
            else:
                program.append((_INSTRUCTIONS[name], (*values, column[into[0]])))
        return program, inputs, outputs


_HALF, _ONE, _TWO = map(np.array, (0.5, 1.0, 2.0))


def _turn(angle: np.ndarray, sine: np.ndarray, cosine: np.ndarray) -> None:
    """Compute both of an angle by the tangent of its half, a third of the work of NumPy's own."""
    np.multiply(angle, _HALF, sine)
    np.tan(sine, sine)
    np.square(sine, cosine)
    np.add(cosine, _ONE, cosine)
    np.divide(_TWO, cosine, cosine)
    np.multiply(sine, cosine, sine)
    np.subtract(cosine, _ONE, cosine)


def _chosen(condition: np.ndarray, value: np.ndarray, out: np.ndarray) -> None:
    np.copyto(out, np.where(condition, value, 0.0))


_INSTRUCTIONS: dict[str, Any] = {
    **dict.fromkeys(("CONST", "INPUT", "OUTPUT", "SIN", "COS")),
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
"""NumPy's functions by the names of CasADi's instructions."""
_NAMES = {int(getattr(ca, f"OP_{name}")): name for name in _INSTRUCTIONS}
