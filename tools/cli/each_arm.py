"""A verb for each arm of a calibration in turn."""

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import cached_property, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import MukcaError
from ...solver import assessment, calibration
from ...solver.calibration import UsageError
from .console import Terminal
from .robots import paths_by_robot

if TYPE_CHECKING:
    from rich.console import Console


OUTPUTS = ("out", "certificate")
"""Options that name what is written; of several robots each has its own."""


class ArmError(MukcaError):
    """A verb refuses one of several arms; the line names that arm first."""


class _TerminalOfArm(Terminal):
    """Terminal that names its arm above the first line, and keeps the JSON."""

    def __init__(self, terminal: Terminal, name: str) -> None:
        super().__init__(
            json=terminal.json,
            brief=terminal.brief,
            quiet=terminal.quiet,
            verbose=terminal.verbose,
        )
        self.name = name
        self.is_headed = False
        self.result: Any = None

    def _name_arm(self) -> None:
        if not self.is_headed:
            self.is_headed = True
            super().say(f"Robot {self.name}")

    @cached_property
    def console(self) -> "Console":
        """The console, below the arm's name."""
        self._name_arm()
        return super().console

    def say(self, *texts: str) -> None:
        """Write lines below the arm's name."""
        if texts:
            self._name_arm()
            super().say(*texts)

    def warn(self, *texts: str, level: str = "warning") -> None:
        """Write warnings below the arm's name."""
        if texts:
            self._name_arm()
            super().warn(*texts, level=level)

    def emit(self, value: Any) -> None:
        """Keep the arm's result."""
        self.result = value if isinstance(value, dict) else value.as_dict()


def one_arm(file: Path) -> Path:
    """Return the ``calibration.json`` of a single robot; several are a UsageError."""
    files = calibration.calibration_files(file)
    if "" not in files:
        folders = ", ".join(str(path.parent) for path in files.values())
        raise UsageError(f"{file}: holds several robots; name one of {folders}")
    return files[""]


def for_each_arm(run: Callable[[Any, Terminal], int]) -> Callable[[Any, Terminal], int]:
    """Verb that runs for each robot of a calibration, and returns the worst exit status.

    Each has placements of its own, ``NAME:PATH``, and writes what is named after it. An ArmError
    names the robot that is refused.
    """

    @wraps(run)
    def run_all(options: Any, terminal: Terminal) -> int:
        files = calibration.calibration_files(options.calibration)
        if "" in files:
            return run(replace(options, calibration=files[""]), terminal)
        recordings = (
            paths_by_robot(options.data, files) if hasattr(options, "data") else None
        )
        results = dict[str, Any]()
        statuses = list[int]()
        for name, file in files.items():
            settings: dict[str, Any] = {
                "calibration": file,
                **_outputs_of_arm(options, name),
            }
            if recordings is not None:
                settings["data"] = recordings[name]
            if recordings is None or settings["data"]:
                terminal_of_arm = _TerminalOfArm(terminal, name)
                statuses.append(
                    _run_arm(run, replace(options, **settings), terminal_of_arm)
                )
                results[name] = terminal_of_arm.result
        terminal.emit({"robots": results})
        return assessment.worst(statuses)

    return run_all


def _run_arm(
    run: Callable[[Any, Terminal], int], options: Any, terminal: _TerminalOfArm
) -> int:
    try:
        return run(options, terminal)
    except MukcaError as error:
        refusal = ArmError(f"{terminal.name}: {error}")
        refusal.failed = error.failed
        raise refusal from None


def _outputs_of_arm(options: Any, name: str) -> Mapping[str, Path]:
    """Return folders and files to write, named after an arm.

    A dot begins the ending of a file, unless a digit follows, as in ``results-1.0``.
    """
    outputs: dict[str, Path] = {}
    entries = (entry for entry in fields(options) if entry.name in OUTPUTS)
    for entry in entries:
        path = getattr(options, entry.name)
        if path is None:
            continue
        has_ending = path.suffix[1:2].isalpha()
        if has_ending and entry.metadata["metavar"] != "DIR":
            outputs[entry.name] = path.with_name(f"{path.stem}_{name}{path.suffix}")
        else:
            outputs[entry.name] = path / name
    return outputs
