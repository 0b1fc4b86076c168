"""Calls CasADi functions on the rows of NumPy arrays, in whose memory they read and write.

CasADi's own call turns arrays into lists and back, which takes longer than the computation.
"""

from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
import numpy as np

from .column_program import ColumnProgram, Instruction, instructions_of

BATCH = 208
"""Rows that are computed at once: the results of more no longer fit into a processor's cache."""
STEP = 4
"""CasADi prepares a function for each number of rows: some rows twice cost less."""
MANY = 256
"""Rows from which on NumPy goes through the columns."""
BLOCK = 512
"""Rows whose columns are computed at once."""


class RowFunction:
    """A CasADi function whose last argument is one row; the other arguments serve all rows.

    Its inputs are column vectors of symbols, its outputs vectors or matrices. CasADi goes through
    all instructions row by row. Of many rows, NumPy computes each instruction for all of them at
    once, in a fifth of the time. What is computed ``times`` times is each time computed of the
    output before: then there is one input, a row, and one output like it.
    """

    def __init__(
        self,
        name: str,
        inputs: list[Any],
        outputs: list[Any],
        times: int = 1,
    ) -> None:
        # CasADi writes column by column, NumPy reads row by row.
        turned = [ca.densify(ca.SX(output).T) for output in outputs]
        self._sizes = [output.numel() for output in turned]
        self._lengths = [symbol.numel() for symbol in inputs]
        function = ca.Function(name, inputs, turned, {"cse": True})
        self.function = function.fold(times) if times > 1 else function
        self._mapped = lru_cache(maxsize=32)(self._map)
        self._program = lru_cache(maxsize=8)(self._column_program)

    def __call__(
        self,
        rows: np.ndarray,
        *constants: np.ndarray,
    ) -> list[np.ndarray]:
        """Return each output for each row, shape (N, k); the other arguments serve all rows."""
        arguments = [np.asarray(values, dtype=float) for values in (*constants, rows)]
        lengths = [values.shape[-1] for values in arguments]
        if lengths != self._lengths:  # CasADi would read beyond them
            raise ValueError(f"arguments of lengths {lengths}, not {self._lengths}")
        if len(rows) >= MANY and self._known:
            return self._by_columns(*arguments)
        return self._by_rows(*arguments)

    @cached_property
    def _instructions(self) -> list[Instruction]:
        """The function's instructions."""
        return instructions_of(self.function)

    @cached_property
    def _known(self) -> bool:
        """True where NumPy knows all instructions."""
        return all(instruction.name for instruction in self._instructions)

    def _by_rows(self, *arguments: np.ndarray) -> list[np.ndarray]:
        """Return each output as CasADi computes it, some rows at a time."""
        *fixed, rows = map(np.ascontiguousarray, arguments)
        count = len(rows)
        if count > STEP and count % STEP:
            copies = np.repeat(rows[-1:], -count % STEP, axis=0)
            rows = np.concatenate([rows, copies])
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
        function = self.function
        shared = list(range(function.n_in() - 1))
        mapped = function.map(f"{function.name()}_{N}", "serial", N, shared, [])
        return mapped, []

    def _by_columns(self, *arguments: np.ndarray) -> list[np.ndarray]:
        """Return each output as NumPy computes it, column by column."""
        *fixed, rows = arguments
        results = [np.empty((size, len(rows))).T for size in self._sizes]
        for begin in range(0, len(rows), BLOCK):
            batch = rows[begin : begin + BLOCK]
            count = len(batch)
            next_power = 1 << (count - 1).bit_length()
            program = self._program(max(MANY, next_power))
            for columns, values in zip(program.inputs, (*fixed, batch), strict=True):
                columns[:, :count] = np.atleast_2d(values).T
            program.run()
            for columns, result in zip(program.outputs, results, strict=True):
                result[begin : begin + count] = columns[:, :count].T
        return results

    def _column_program(self, rows: int) -> ColumnProgram:
        """Return the program for a number of rows."""
        return ColumnProgram.of(self.function, self._instructions, rows)
