"""Calls CasADi functions on the rows of NumPy arrays.

CasADi's own call turns arrays into lists of Python numbers and back, which takes several times as
long as the computation; here it reads and writes the arrays' memory.
"""

from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

BATCH = 200
"""Rows that are computed at once: the results of more no longer fit into a processor's cache."""


class RowFunction:
    """A CasADi function whose last argument is one row; the other arguments serve all rows.

    Args:
        name: What CasADi calls it.
        inputs: Its symbols, column vectors.
        outputs: Its values, vectors or matrices.
    """

    def __init__(self, name: str, inputs: list[Any], outputs: list[Any]) -> None:
        # CasADi writes column by column, NumPy reads row by row.
        turned = [ca.densify(ca.SX(output).T) for output in outputs]
        self._sizes = [output.numel() for output in turned]
        self._lengths = [symbol.numel() for symbol in inputs]
        self._function = ca.Function(name, inputs, turned)
        self._mapped = lru_cache(maxsize=32)(self._map)

    def __call__(self, rows: np.ndarray, *others: np.ndarray) -> list[np.ndarray]:
        """Return each output for each row, shape (N, k); the other arguments serve all rows."""
        arguments = [np.ascontiguousarray(values, dtype=float) for values in (*others, rows)]
        lengths = [values.shape[-1] for values in arguments]
        if lengths != self._lengths:  # CasADi would read beyond them
            raise ValueError(f"arguments of lengths {lengths}, not {self._lengths}")
        *fixed, rows = arguments
        results = [np.empty((len(rows), size)) for size in self._sizes]
        for begin in range(0, len(rows), BATCH):
            batch = slice(begin, begin + BATCH)
            buffer, run = self._mapped(len(rows[batch])).buffer()
            for i, values in enumerate((*fixed, rows[batch])):
                buffer.set_arg(i, values.data)
            for i, values in enumerate(results):
                buffer.set_res(i, values[batch].data)
            run()
        return results

    def _map(self, N: int) -> Any:
        """Return the function for N rows; its arguments but the last are the same for each."""
        shared = list(range(self._function.n_in() - 1))
        return self._function.map(f"{self._function.name()}_{N}", "serial", N, shared, [])
