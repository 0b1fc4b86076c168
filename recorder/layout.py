"""Tables of which it is known what they hold: a model's joints, poses, or points beside them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

from .columns import Column
from .coordinates import AXES, MAKERS, MATRIX, QUATERNION, RPY, TURNS, VECTOR
from .foreign_tables import read_table
from .joint_columns import ColumnError, match_joints, require_samples
from .points import coordinates, require_unit, require_vectors, vector_note
from .recording_error import RecordingError
from .samples import read_samples
from .tables import Table
from .words import ANGLES, SIZES, Names

POSE_FORMS = (*((*AXES, *turn) for turn in TURNS), AXES)
"""Columns of a pose; a place alone comes last, since it leaves the others out."""
_TURNED = {*QUATERNION, *VECTOR, *RPY, *MATRIX, *MAKERS}
_EVENTS = ("event", "sample", "socket")


@dataclass(frozen=True)
class Rows:
    """Numbers of a table in radians and metres, the wanted columns in order."""

    numbers: list[tuple[float, ...]]
    """Joint positions, then the columns of the form."""
    wheres: list[str]
    """File and line of each row."""
    form: tuple[str, ...]
    """Names of the columns behind the joints."""
    notes: tuple[str, ...] = ()
    """Remarks for people: what is taken in order, what is left out."""


def read_rows(
    file: Path,
    joint_names: Names = (),
    forms: Sequence[Names] = ((),),
) -> Rows:
    """Read a model's joints from a file, and one of some forms beside them.

    Args:
        file: A table with or without a header, see :func:`.read_table`.
        joint_names: The model's joints, in chain order; none for poses.
        forms: Names of other columns, the richest form first. The error for a table that has none
            says which columns are needed.

    Raises:
        RecordingError: Columns are missing, or may be several; the message says which are needed.
    """
    return rows_of(read_table(file, joint_names), joint_names, forms)


def rows_of(
    table: Table,
    joint_names: Names,
    forms: Sequence[Names] = ((),),
) -> Rows:
    """Return the rows of a table as :func:`read_rows` does."""
    require_samples(table.labels, joint_names, table.file)
    columns, form, note = _Search(table, joint_names, forms).columns()
    if table.header and table.header[:3] == _EVENTS:
        # A recording; its samples are those that were not taken back.
        content = read_samples(table.file)
        match = match_joints(content.joint_names, joint_names)
        order = match.order if match else range(len(joint_names))
        rows = [tuple(sample.position[i] for i in order) for sample in content.live]
        wheres = [sample.where for sample in content.live]
        return Rows(rows, wheres, (), (note,) if note else ())
    filled = filled_rows(table, columns)
    notes = [*table.notes, *([f"{table.file}: {note}"] if note else [])]
    if blank := len(table.rows) - len(filled.rows):
        notes.append(f"{table.file}: {blank} lines without values are left out")
    numbers = filled.numbers(columns)
    wheres = [f"{table.file}:{line}" for line in filled.lines]
    if vectors := vector_note(table, columns, form):
        require_vectors(numbers, wheres)
        notes.append(vectors)
    return Rows(numbers, wheres, tuple(form), tuple(notes))


def filled_rows(table: Table, columns: Sequence[Column]) -> Table:
    """Return a table without the rows that hold nothing in some columns."""
    used = [column.index for column in columns]
    pairs = zip(table.lines, table.rows, strict=True)
    filled = [(line, row) for line, row in pairs if any(row[i] for i in used)]
    lines, rows = zip(*filled, strict=True) if filled else ((), ())
    return replace(table, lines=lines, rows=rows)


@dataclass(frozen=True)
class _Search:
    """Search for a model's joints in a table, and for one of some forms beside them."""

    table: Table
    joint_names: Names
    forms: Sequence[Names]

    def columns(self) -> tuple[list[Column], Names, str]:
        """Return the joints' columns and those of the first form that is there, and a remark."""
        table = self.table
        if table.header is None:
            return self._in_order()
        last_words = {(column.words or ("",))[-1] for column in table.columns}
        for form in self.forms:
            form_columns = coordinates(table, form) if form else []
            # Columns may belong to a richer form that is not complete.
            richer = set(chain.from_iterable(self.forms)).difference(form, MAKERS)
            if form_columns is None:
                continue
            unread = [c.unit for c in table.columns if c not in form_columns]
            angles = ANGLES.keys() & unread if not self.joint_names else ()
            if _TURNED.isdisjoint(form) and (
                angles or not richer.isdisjoint(last_words)
            ):
                continue
            try:
                joints = find_joints(table, self.joint_names, form_columns)
            except ColumnError as error:
                raise RecordingError(
                    f"{table.file}:1: {error}; keep those of one arm"
                ) from None
            if joints:
                return [*joints[0], *form_columns], form, joints[1]
        header = ",".join(table.header)
        raise RecordingError(
            f"{table.file}: its header is {header:.60}; needed: {self._wanted()}"
        )

    def _in_order(self) -> tuple[list[Column], Names, str]:
        """Return the columns of a table without a header, as many as one form has."""
        columns = self.table.joints()
        size = len(columns) - len(self.joint_names)
        fitting = [form for form in self.forms if len(form) == size]
        if len(fitting) != 1:
            reason = (
                "that many are several kinds of pose"
                if fitting
                else "no such number is known"
            )
            raise RecordingError(
                f"{self.table.file}: its header is missing, and {len(columns)} columns without one "
                f"tell nothing: {reason}; needed: {self._wanted()}"
            )
        names = ",".join((*self.joint_names, *fitting[0]))
        note = f"no header; the columns are taken in order, as {names:.120}"
        return columns, fitting[0], note

    def _wanted(self) -> str:
        """Return the headers that would do."""
        forms = filter(MAKERS.isdisjoint, reversed(self.forms))
        return "; or ".join(",".join((*self.joint_names, *form)) for form in forms)


def find_joints(
    table: Table,
    joint_names: Names,
    reserved: Sequence[Column] = (),
) -> tuple[list[Column], str] | None:
    """Return the columns of a model's joints in chain order, and a remark; None without them.

    Columns of a place are not taken for joints in order.

    Raises:
        ColumnError: Several columns may be one joint.
        RecordingError: A joint's column has a unit that is not known.
    """
    if not joint_names:
        return [], ""
    joints = table.joints(reserved)
    beside = [c for c in table.columns if c not in reserved and c not in joints]
    columns = [*joints, *beside]
    names = [column.name for column in columns]
    match = match_joints(names[: len(joints)], joint_names, beside=names[len(joints) :])
    if not match:
        return None
    if match.note and {names[i].lower() for i in match.order}.issuperset(AXES):
        return None
    joints = [columns[i] for i in match.order]
    require_units(table, joints)
    return joints, match.note


def require_units(table: Table, joints: Sequence[Column]) -> None:
    """Refuse joints in a unit that is not known; a RecordingError names the first."""
    for joint in joints:
        require_unit(table, joint, SIZES)
