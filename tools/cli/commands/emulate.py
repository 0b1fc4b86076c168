"""``mukca emulate``: a controller that speaks the real bytes, to try things without a robot."""

import argparse
import importlib
import math
import signal
import sys
from pathlib import Path

from ....drivers.arms import Fault, SimulatedArm
from ....errors import MukcaError
from ...emulators import KINDS, Emulator, FaultInjector, Journal, replay_arm, wandering_arm
from .. import Terminal

EMULATORS = {
    "damiao": "damiao:DamiaoEmulator",
    "dynamixel": "dynamixel:DynamixelEmulator",
    "feetech": "feetech:FeetechEmulator",
    "franka": "franka:FrankaEmulator",
    "kinova": "kinova:KinovaEmulator",
    "kuka": "kuka:KukaEmulator",
    "piper": "piper:PiperEmulator",
    "ur": "ur:UrEmulator",
    "xarm": "xarm:XArmEmulator",
}
_KINDS = "\n".join(f"  {kind:<11} {what}" for kind, what in KINDS.items())
_EXAMPLE = f"""example:
  mukca emulate franka --version 10
  mukca stream --driver franka:127.0.0.1        (in another terminal)

faults are KIND[:SHARE][@START[+DURATION]], as in drop:0.05 or silent@3+0.5: a share of the
messages, from a time after the first connection on, for so many seconds; the kinds are
{_KINDS}
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = _EXAMPLE
    parser.add_argument("controller", choices=sorted(EMULATORS))
    parser.add_argument("--version", metavar="V", help="of the protocol or the controller")
    parser.add_argument(
        "--address", default="", help="where it listens (default: the real ports on loopback)"
    )
    parser.add_argument(
        "--recording", type=Path, metavar="DIR", help="move through a placement, then rest"
    )
    parser.add_argument("--hold", type=float, default=1.0, metavar="S", help="rest at a pose (1)")
    parser.add_argument("--move", type=float, default=1.0, metavar="S", help="move to the next (1)")
    parser.add_argument(
        "--wait", action="store_true", help="rest at the first pose until Enter is pressed"
    )
    parser.add_argument("--noise", type=float, default=2e-5, metavar="RAD", help="encoders (2e-5)")
    parser.add_argument("--rate", type=float, metavar="HZ", help="states per second")
    parser.add_argument("--fault", action="append", default=[], metavar="KIND...", help="as below; "
        "may be repeated")  # fmt: skip
    parser.add_argument("--seed", type=int, default=0, help="of the faults (0)")
    parser.add_argument("--journal", type=Path, metavar="FILE", help="note what comes in and out")
    parser.add_argument("--json", action="store_true", help="tell the address as a JSON object")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Emulate until interrupted or terminated."""
    emulator = open_emulator(arguments)
    if arguments.wait:
        emulator.wait_for_line(sys.stdin.fileno())
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        _tell(arguments, emulator, terminal)
        emulator.serve()
    except KeyboardInterrupt:
        pass
    finally:
        emulator.close()
        emulator.journal.close()
    return 0


def open_emulator(arguments: argparse.Namespace) -> Emulator:
    """Return the emulator that was asked for, listening."""
    kind = _load(arguments.controller)
    version = arguments.version or kind.VERSIONS[0]
    if version not in kind.VERSIONS:
        raise MukcaError(
            f"{arguments.controller} has no version {version}; one of: {', '.join(kind.VERSIONS)}"
        )
    try:
        faults = [Fault.parse(text, KINDS, math.inf) for text in arguments.fault]
    except ValueError as error:
        raise MukcaError(str(error)) from None
    for fault in faults:
        if fault.kind not in kind.FAULTS:
            raise MukcaError(
                f"no fault {fault.kind!r} at {arguments.controller}; "
                f"there are: {', '.join(kind.FAULTS)}"
            )
    journal, injector = Journal(arguments.journal), FaultInjector(faults, arguments.seed)
    arm = _arm(arguments, kind, version)
    try:
        return kind(arguments.address, version, arm, injector, journal)
    except OSError as error:
        raise MukcaError(f"{arguments.controller}: cannot listen: {error}") from None


def _load(name: str) -> type[Emulator]:
    module, _, attribute = EMULATORS[name].partition(":")
    loaded: type[Emulator] = getattr(
        importlib.import_module(f"...emulators.{module}", __package__), attribute
    )
    return loaded


def _arm(arguments: argparse.Namespace, kind: type[Emulator], version: str) -> SimulatedArm:
    rate = kind.RATES[version] if arguments.rate is None else arguments.rate
    if min(rate, arguments.move) <= 0 or min(arguments.hold, arguments.noise) < 0:
        raise MukcaError("--rate and --move are positive; --hold and --noise not negative")
    motion, joints = (arguments.hold, arguments.move), kind.joints(version)
    if arguments.recording is None:
        return wandering_arm(joints, rate, motion, arguments.noise)
    return replay_arm(arguments.recording, joints, rate, motion, arguments.noise)


def _tell(arguments: argparse.Namespace, emulator: Emulator, terminal: Terminal) -> None:
    if arguments.json:
        terminal.emit({"driver": emulator.driver_address, "version": emulator.version})
        return
    terminal.say(f"Emulating {arguments.controller}, version {emulator.version}.")
    terminal.say(f"Read it with: mukca stream --driver '{emulator.driver_address}'")
    if arguments.wait:
        terminal.say("Press Enter to let the arm move.")
    terminal.say("End it with Ctrl-C.")
