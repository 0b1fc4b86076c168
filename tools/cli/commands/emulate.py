"""``mukca emulate``: a controller that speaks the real bytes, to try things without a robot."""

import math
import signal
import sys
from collections.abc import Sequence
from pathlib import Path

from ....drivers.arms import Fault
from ....errors import MukcaError
from ... import emulators
from ...emulators import KINDS, Emulator, FaultInjector, Journal, emulated_arm
from .. import NOT_NEGATIVE, POSITIVE, Options, Terminal, argument, option

EMULATORS = {
    name.removesuffix("Emulator").lower(): name
    for name in dir(emulators)
    if name.endswith("Emulator") and name != "Emulator"
}
"""Class of each controller, on the face of the emulators."""
LIST = "\n".join(f"  {kind:<11} {what}" for kind, what in KINDS.items())


class _EmulateOptions(Options):
    controller: str = argument("the controller to play", choices=sorted(EMULATORS))
    version: str | None = option(None, "version of the protocol or the controller", "V")
    address: str = option(
        "", "address to listen at (default: the real ports on loopback)"
    )
    recording: Path | None = option(None, "move through a placement, then rest", "DIR")
    hold: float = option(1.0, "seconds to rest at each pose", "S", between=NOT_NEGATIVE)
    move: float = option(1.0, "seconds to move to the next pose", "S", between=POSITIVE)
    wait: bool = option(False, "rest at the first pose until Enter is pressed")
    noise: float = option(
        2e-5, "standard deviation of the encoders' noise", "RAD", between=NOT_NEGATIVE
    )
    rate: float | None = option(None, "states per second", "HZ", between=POSITIVE)
    fault: Sequence[str] = option(
        (), "a fault, as below; may be repeated", "KIND...", repeated=True
    )
    seed: int = option(0, "seed of the faults (default: 0)")
    journal: Path | None = option(None, "note what comes in and out", "FILE")
    json: bool = option(False, "tell the address as a JSON object")


def run_emulate(options: _EmulateOptions, terminal: Terminal) -> int:
    """Emulate until interrupted or terminated."""
    emulator = open_emulator(options)
    if options.wait:
        emulator.wait_for_line(sys.stdin.fileno())
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        terminal.emit({"driver": emulator.driver_address, "version": emulator.version})
        if not options.json:
            terminal.say(
                f"Emulating {options.controller}, version {emulator.version}.",
                f"Read it with: mukca stream --driver '{emulator.driver_address}'",
                *(["Press Enter to let the arm move."] if options.wait else []),
                "End it with Ctrl-C.",
            )
        emulator.serve()
    except KeyboardInterrupt:
        pass
    finally:
        emulator.close()
        emulator.journal.close()
    return 0


def open_emulator(options: _EmulateOptions) -> Emulator:
    """Return the emulator that was asked for, listening."""
    kind: type[Emulator] = getattr(emulators, EMULATORS[options.controller])
    version = options.version or next(iter(kind.VERSIONS))
    if version not in kind.VERSIONS:
        raise MukcaError(
            f"{options.controller} has no version {version}; one of: {', '.join(kind.VERSIONS)}"
        )
    try:
        faults = [Fault.parse(text, KINDS, math.inf) for text in options.fault]
    except ValueError as error:
        raise MukcaError(str(error)) from None
    for fault in faults:
        if fault.kind not in kind.FAULTS:
            raise MukcaError(
                f"no fault {fault.kind!r} at {options.controller}; "
                f"there are: {', '.join(kind.FAULTS)}"
            )
    journal = Journal(options.journal)
    injector = FaultInjector(faults, options.seed)
    joints, usual_rate = kind.VERSIONS[version]
    rate = usual_rate if options.rate is None else options.rate
    motion = options.hold, options.move
    arm = emulated_arm(joints, rate, motion, options.noise, options.recording)
    try:
        return kind(options.address, version, arm, injector, journal)
    except OSError as error:
        raise MukcaError(f"{options.controller}: cannot listen: {error}") from None
