"""Driver of a simulated arm, which replays configurations and misbehaves on demand.

Address: ``PATH?option=value&...``; docs/simulated-arm.md lists options and faults.
"""

import csv
import math
from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from urllib.parse import parse_qsl

from ...errors import read_bytes, reason_of
from .. import (
    Driver,
    JointNames,
    JointState,
    JointValues,
    ModelNames,
    Reason,
    clock,
    match_joints,
)
from .simulated_arm import Fault, Motion, SimulatedArm

_Rows = list[JointValues]


class Mock(Driver):
    """A connection to a simulated arm.

    It stands in for a robot in tests, in the demo, and while writing a program that reads robots.

    Args:
        address: As in the module's docstring; ignored where an arm is given.
        joint_names: The model's actuated joints, in chain order.
        arm: The arm to connect to, for use from Python; see :func:`arm_at`.

    Raises:
        DriverError: BAD_ADDRESS for an address without a recording or with an option that does
            not exist; WRONG_ROBOT for another number of joints; UNREACHABLE during a drop.
    """

    # A connection that a fault ended can be made again: arms with such a fault are kept here by
    # their address, and go on moving until the next connection to the same address finds them.
    _left: dict[str, SimulatedArm] = {}  # noqa: RUF012 - shared on purpose

    def __init__(
        self,
        address: str = "",
        joint_names: ModelNames = None,
        *,
        arm: SimulatedArm | None = None,
    ) -> None:
        self._address = address
        self._arm = arm or self._left.pop(address, None) or arm_at(address)
        self._names = self._arm.joint_names
        same = sorted(joint_names or ()) == sorted(self._names)
        if joint_names is not None and not same:
            self._names = match_joints(joint_names, len(self._names), "the recording")
        self._open = False
        if self._arm.shows("drop", self._arm.now()):
            self._leave()
            raise Reason.UNREACHABLE("the simulated arm does not answer")
        self._next = self._arm.connect()
        self._last: JointState | None = None
        self._open = True

    @property
    def joint_names(self) -> JointNames:
        """Names of the joints: the model's where it is known, else the recording's own.

        They stand in the recording's order where that has the model's names.
        """
        return self._names

    def read(self, timeout: float) -> JointState:
        """Return the next state, no sooner than the arm sends it; see :meth:`Driver.read`."""
        deadline = clock.now() + timeout
        while True:
            if not self._open:
                raise Reason.UNREACHABLE("the connection is closed")
            self._skip_lost()
            due = self._arm.due(self._next)
            now = clock.now()
            if due > now:
                clock.sleep(max(0.0, min(due, deadline) - now))
                if due > deadline:
                    raise Reason.SILENT(f"no state came within {timeout:g} s")
            state = self._receive()
            if state:
                return state

    def close(self) -> None:
        """End the connection; safe to call twice."""
        if self._open:
            self._open = False
            self._leave()

    def _leave(self) -> None:
        now = self._arm.now()
        if self._address and any(fault.is_active(now) for fault in self._arm.faults):
            self._left[self._address] = self._arm

    def _skip_lost(self) -> None:
        """Skip the states that no longer fit the buffer, as a socket drops them."""
        late = self._arm.now() - self._next / self._arm.rate - self._arm.buffer
        lost = math.ceil(max(0.0, late) * self._arm.rate)
        self.missed += lost
        self._next += lost

    def _receive(self) -> JointState | None:
        moment = self._next / self._arm.rate
        self._next += 1
        if self._arm.shows("drop", moment):
            self.close()
            raise Reason.UNREACHABLE("the simulated arm dropped the connection")
        if self._arm.shows("silent", moment):
            return None
        if self._last is None or not self._arm.shows("repeat", moment):
            self._last = self._arm.state(moment)
        return self._last


def arm_at(address: str) -> SimulatedArm:
    """Return the arm that an address describes; raises as :class:`Mock`."""
    path, _, query = address.partition("?")
    if not path:
        raise Reason.BAD_ADDRESS(
            "mock needs a recording to replay, as in mock:data/front"
        )
    options = dict[str, float]()
    faults: list[Fault] = []
    names = ("rate", "hold", "move", "noise", "effort_noise", "seed", "speed", "buffer")
    try:
        pairs = parse_qsl(query.replace("+", "%2B"), True, strict_parsing=bool(query))
        for name, value in pairs:
            if name == "fault":
                faults.append(Fault.parse(value))
            elif name not in names:
                raise ValueError(
                    f"option {name!r} is none of {', '.join((*names, 'fault'))}"
                )
            elif (parsed := _number(value)) is None:
                raise ValueError(f"option {name}: {value!r} is not a number")
            else:
                options[name] = parsed
        return _build(Path(path), options, faults)
    except ValueError as error:
        raise Reason.BAD_ADDRESS(f"mock:{address}: {error}") from None


def _build(path: Path, options: dict[str, float], faults: list[Fault]) -> SimulatedArm:
    """Return the arm that replays a CSV file, or all recordings in a placement's folder."""
    files = sorted([*path.glob("hole_*.csv"), *path.glob("samples.csv")]) or [path]
    names, positions, torques = zip(*map(_read, files), strict=True)
    configurations = list(chain.from_iterable(positions))
    efforts = list(chain.from_iterable(torques))
    if not configurations:
        raise Reason.BAD_ADDRESS(f"mock: {path}: no configuration to replay")
    hold = options.pop("hold", Motion.hold)
    move = options.pop("move", Motion.move)
    return SimulatedArm(
        Motion(configurations, hold=hold, move=move),
        joint_names=names[0],
        efforts=efforts if len(efforts) == len(configurations) else None,
        seed=int(options.pop("seed", 0)),
        faults=faults,
        **options,
    )


def _number(text: str) -> float | None:
    """Return a text's number, or None."""
    try:
        return float(text)
    except ValueError:
        return None


def _read(file: Path) -> tuple[JointNames, _Rows, _Rows]:
    """Return a file's joint names, positions [rad] and efforts [N m]."""
    try:
        text = read_bytes(file).decode("utf-8-sig")
        lines = [line for line in csv.reader(text.splitlines()) if line]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise Reason.BAD_ADDRESS(
            f"mock: {file}: cannot be read: {reason_of(error)}"
        ) from None
    first = lines[0] if lines else ["0"]
    header: list[str] = []
    if _number(first[0]) is None:
        header = lines.pop(0)
    positions = [i for i, name in enumerate(header) if name.startswith("position.")]
    efforts = [i for i, name in enumerate(header) if name.startswith("effort.")]
    columns = positions or list(range(len(first)))
    names = tuple(header[i].removeprefix("position.") for i in columns if header)
    return names, _pick(lines, columns), _pick(lines, efforts)


def _pick(lines: Sequence[Sequence[str]], columns: Sequence[int]) -> _Rows:
    """Return the numbers in some columns, of the lines that have all of them."""
    rows = list[JointValues]()
    for line in lines:
        cells = [line[i].strip() for i in columns if i < len(line)]
        if columns and len(cells) == len(columns) and all(cells):
            rows.append(tuple(map(float, cells)))
    return rows
