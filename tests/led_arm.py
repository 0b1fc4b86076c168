"""``mukca`` on a simulated arm that a test leads: ``python led_arm.py STEPS record ...``.

The arm rests until the file STEPS is a line longer, and then moves on to its next configuration, or
to that which the line gives [rad]: nothing is missed, however busy the computer is.
"""

import sys
from dataclasses import dataclass, field
from pathlib import Path

from mukca.drivers.arms import Motion
from mukca.drivers.arms import simulated as mock
from mukca.tools.cli import main


@dataclass(frozen=True)
class Led(Motion):
    """A motion that waits at each rest for as long as the test wants."""

    begun: list[float] = field(default_factory=list)
    """When each move began [s]."""

    def phase(self, time):
        """Return the number of the last rest, and how far the move after it has come, 0 to 1."""
        lines = STEPS.read_text().splitlines()
        if len(lines) > len(self.begun):
            if to := lines[len(self.begun)]:
                self.configurations[len(self.begun) + 1 :] = [tuple(map(float, to.split(",")))]
            self.begun.append(max([time, *(begun + self.move for begun in self.begun[-1:])]))
        if not self.begun:
            return 0, 0.0
        index, progress = len(self.begun) - 1, (time - self.begun[-1]) / self.move
        return (index + 1, 0.0) if progress >= 1 else (index, max(0.0, progress))


STEPS = Path(sys.argv.pop(1))

if __name__ == "__main__":
    mock.Motion = Led
    sys.exit(main())
