"""Read emulated controllers at their rates for a minute: states lost, CPU, latency.

::

    python benchmarks/stream.py [--seconds 60] [NAME ...]

The emulator is a program of its own and writes down when it sent each state (its journal); the
latency is from then to when the state was read here, by the clock that both share. The CPU share
is of one core, for reading and decoding alone. The baseline of each line is a loop that receives
the same bytes and decodes nothing; the ratio of the two is printed. The last line is the UR read
by the driver ur-rtde instead, where that is installed. Servos send a state only when they are
asked: there the lost ones are requests that had to be repeated, since no whole answer came within
0.1 s, and there is no bare loop.
"""

import argparse
import json
import select
import subprocess
import sys
import tempfile
import time
from bisect import bisect
from importlib.util import find_spec
from pathlib import Path

from mukca.drivers import Driver, open_driver

STREAMS = {
    "franka-5": ("franka", ("--version", "5")),
    "franka-10": ("franka", ("--version", "10")),
    "kuka-1.15": ("kuka", ("--version", "1.15")),
    "kuka-2.7": ("kuka", ("--version", "2.7")),
    "kuka-2.7 at 1 kHz": ("kuka", ("--version", "2.7", "--rate", "1000")),
    "ur": ("ur", ("--version", "5.11")),
    "xarm": ("xarm", ("--version", "xarm6")),
    "feetech": ("feetech", ()),
    "dynamixel": ("dynamixel", ()),
    "damiao": ("damiao", ()),
}
RATES = {"franka": 1000.0, "kuka": 200.0, "ur": 500.0, "xarm": 250.0}
# Clocks start here.
CLOCKS = {
    "franka": 0.0,
    "kuka": 1_700_000_000.0,
    "ur": 0.0,
    "xarm": 5.0,
}
POLLED = {"feetech": "?rate=300", "dynamixel": "?rate=200", "damiao": "?rate=100"}
"""What is asked of the driver: as fast as such a bus of servos is at 1 Mbaud."""
# CAN without hardware.
BUS = (
    "--address",
    "udp_multicast/239.74.163.2?port=43198&hop_limit=0",
)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--seconds", type=float, default=60.0)
    arguments = parser.parse_args()
    if not arguments.names:
        arguments.names = [
            *STREAMS,
            *(["ur, by ur-rtde"] if find_spec("rtde_receive") else []),
        ]
    print(
        f"{'stream':18} {'states':>7} {'a second':>8} {'sent':>7} {'lost':>5}", end=""
    )
    print(f" {'CPU':>7} {'x bare':>7} {'p50':>9} {'p99':>9} {'max':>9}")
    for name in arguments.names:
        controller, options = STREAMS[name.partition(",")[0]]
        with tempfile.TemporaryDirectory() as folder:
            journal = Path(folder) / "journal.jsonl"
            measure(name, controller, options, journal, arguments.seconds)


def measure(
    name: str, controller: str, options: tuple[str, ...], journal: Path, seconds: float
) -> None:
    """Read one stream, and print its line."""
    options += BUS if controller == "damiao" else ()
    command = [sys.executable, "-m", "mukca", "emulate", controller, "--json", *options]
    emulator = subprocess.Popen(
        [*command, "--journal", str(journal)], stdout=subprocess.PIPE, text=True
    )
    try:
        assert emulator.stdout
        select.select([emulator.stdout], [], [], 30)
        address = json.loads(emulator.stdout.readline())["driver"]
        polled = POLLED.get(name, "")
        address += polled.replace("?", "&") if "?" in address else polled
        host = address.split(":")[1]
        with open_driver(f"ur-rtde:{host}" if "ur-rtde" in name else address) as driver:
            arrivals, cpu = read(driver, seconds)
            missed, rejected = driver.missed, driver.rejected
        bare = cpu
        if name not in POLLED:
            with open_driver(address) as driver:
                bare = receive(driver, min(seconds, 10.0))
    finally:
        emulator.terminate()
        emulator.wait(30)
    sent = sent_times(journal)
    # What came is what was sent last; the first state was read before.
    if name in POLLED:
        known, moments = list(sent), list(sent.values())
        numbers = [known[bisect(moments, arrival) - 1] for arrival, _ in arrivals]
        count = len(sent) - 1
    else:
        rate = 1000.0 if "1 kHz" in name else RATES[controller]
        numbers = [round((stamp - CLOCKS[controller]) * rate) for _, stamp in arrivals]
        count = numbers[-1] - numbers[0] + 1
    latencies = sorted(
        1e3 * (arrival - sent[number])
        for number, (arrival, _) in zip(numbers, arrivals, strict=True)
    )
    rate = len(arrivals) / (arrivals[-1][0] - arrivals[0][0])
    print(
        f"{name:18} {len(arrivals):7} {rate:8.1f} {count:7} {count - len(arrivals):5} {cpu:7.1%} "
        f"{cpu / bare:7.2f} {latencies[len(latencies) // 2]:6.2f} ms "
        f"{latencies[int(0.99 * len(latencies))]:6.2f} ms {latencies[-1]:6.2f} ms"
        f"  missed {missed}, rejected {rejected}",
        flush=True,
    )


def read(driver: Driver, seconds: float) -> tuple[list[tuple[float, float]], float]:
    """Read states; return arrivals with stamps, and the share of a core that it took."""
    arrivals = []
    driver.read(5)
    start, used = time.monotonic(), time.process_time()
    while time.monotonic() < start + seconds:
        state = driver.read(5)
        arrivals.append((time.monotonic(), state.stamp))
    return arrivals, (time.process_time() - used) / (time.monotonic() - start)


def receive(driver: Driver, seconds: float) -> float:
    """Receive the same bytes without decoding them; return the share of a core."""
    socket = (driver._udp if hasattr(driver, "_udp") else driver._tcp)._socket
    socket.settimeout(0.5)
    start, used = time.monotonic(), time.process_time()
    while time.monotonic() < start + seconds:
        try:
            socket.recv(65535)
        except TimeoutError:
            continue
    return (time.process_time() - used) / (time.monotonic() - start)


def sent_times(journal: Path) -> dict[int, float]:
    """Return when each state was sent, by its number."""
    lines = [json.loads(line) for line in journal.read_text().splitlines()]
    return {line["sent"]: line["at"] for line in lines if "sent" in line}


if __name__ == "__main__":
    main()
