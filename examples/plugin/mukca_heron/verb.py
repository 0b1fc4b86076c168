"""``mukca heron-torques``: what the Heron's joints carry."""

import mukca
from mukca.tools.cli import JsonOption, Terminal, argument


class HeronOptions(JsonOption):
    """Options of the verb."""

    address: str = argument("address of the Heron, HOST[:PORT]", "HOST")


def run(options: HeronOptions, terminal: Terminal) -> int:
    """Show the torques of the Heron's joints.

    Example:
      mukca heron-torques 127.0.0.1
    """
    with mukca.open_driver("heron", options.address) as driver:
        torques = driver.read(timeout=1.0).effort or ()
    terminal.say(*(f"{torque:.2f} N m" for torque in torques))
    terminal.emit({"torques": list(torques)})
    return 0
