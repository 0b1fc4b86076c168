"""Samples as a table: one row a sample, one column for each thing that is known of all.

Tables that have more columns extend it, and are built, joined and selected from likewise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Literal, TypeVar, get_args

if TYPE_CHECKING:
    import numpy as np
    from typing_extensions import Self

Clock = Literal["index", "time", "temperature", "reverse"]
CLOCKS: tuple[Clock, ...] = get_args(Clock)
"""The last is the index where sockets that follow each other were recorded in reverse order."""


@dataclass(frozen=True)
class SampleRows:
    """N samples of an arm with m joints; its columns are the fields that are arrays."""

    q: "np.ndarray"
    """Joint positions as the encoders read them, shape (N, m) [rad]."""

    def only(self, rows: "np.ndarray | slice") -> "Self":
        """Return some of the rows: by their indices, or by a mask."""
        columns = {name: column[rows] for name, column in _columns(self).items()}
        return replace(self, **columns)


@dataclass(frozen=True)
class Samples(SampleRows):
    """N samples of an arm with m joints, as effects see them."""

    moments: "np.ndarray"
    """Moments that hold the joints, shape (N, 3 m) [N m]: about the joints' own axes, which are
    their torques, then about the first axes across, then about the second."""
    clocks: "np.ndarray | None" = None
    """:data:`CLOCKS` from the first sample of its placement on, shape (N, 4), NaN where not known;
    None for poses that are no samples."""

    @classmethod
    def unloaded(cls, q: "np.ndarray") -> "Self":
        """Return samples of joints that bear nothing."""
        nothing = 0 * q
        return cls(q, nothing.repeat(3, axis=1))

    @property
    def torques(self) -> "np.ndarray":
        """Torques of the joints, shape (N, m) [N m]."""
        return self.moments[:, : self.q.shape[1]]

    @property
    def time(self) -> "np.ndarray":
        """Time since the placement's first sample, shape (N, 1) [s]; 0 where it is not known."""
        return _known(self.clock("time"))

    @property
    def temperature(self) -> "np.ndarray":
        """Temperature above the first sample's, shape (N, 1) [K]; 0 where it is not known."""
        return _known(self.clock("temperature"))

    def clock(self, name: Clock) -> "np.ndarray":
        """Return one of :attr:`clocks`, shape (N, 1); 0 for no sample."""
        if self.clocks is None:
            return 0 * self.q[:, :1]
        return self.clocks[:, [CLOCKS.index(name)]]


def _known(clock: "np.ndarray") -> "np.ndarray":
    """Return a clock with 0 where it is not known."""
    import numpy as np  # the command line reads the names of effects without it

    return np.nan_to_num(clock)


Table = TypeVar("Table", bound=SampleRows)


def joined(tables: Sequence[Table]) -> Table:
    """Return tables one below the other; what is no column is that of the first."""
    import numpy as np

    parts = [_columns(table) for table in tables]
    columns = {
        name: np.concatenate([part[name] for part in parts]) for name in parts[0]
    }
    return replace(tables[0], **columns)


def _columns(table: SampleRows) -> "dict[str, Any]":
    """Return the columns of a table by name."""
    values = {field.name: getattr(table, field.name) for field in fields(table)}
    return {name: value for name, value in values.items() if hasattr(value, "shape")}
