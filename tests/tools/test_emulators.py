"""Emulators outlive their clients, whenever these leave, and whatever they say."""

import os
import random
import socket
import struct
from contextlib import contextmanager

import pytest
from cases import by_table
from emulation import emulated

from mukca import open_driver
from mukca.drivers import clock
from mukca.drivers.transport import CanBus, parse_can_address
from mukca.tools import emulators
from mukca.tools.cli.commands import EMULATORS

LEAVERS = 40
RESET = struct.pack("ii", 1, 0)


@contextmanager
def outlived(name, folder):
    """An emulator that still serves a client after all that happened meanwhile."""
    with emulated(name, folder) as emulation:
        yield emulation
        clock.sleep(0.1)
        with open_driver(name, emulation.address) as driver:
            assert driver.read(1)


def leave(name, address, messages):
    """Send messages and leave at once, before any can be answered."""
    if name in ("franka", "ur", "xarm"):
        host, _, port = address.partition(":")
        with socket.create_connection((host, int(port or 30000))) as client:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
            client.sendall(b"".join(messages))
    elif name == "kuka":
        host, port = address.partition("?")[0].split(":")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
            for message in messages:
                client.sendto(message, (host, int(port)))
    elif "//" in address.partition("?")[0] or address.startswith("/"):
        line = os.open(address.removeprefix("serial://").partition("?")[0], os.O_RDWR | os.O_NOCTTY)
        os.write(line, b"".join(messages))
        os.close(line)
    else:
        bus = CanBus(parse_can_address(address))
        for message in messages:
            bus.send(0x7FF, message[:8])
        bus.close()


@pytest.mark.parametrize("name", EMULATORS)
def test_clients_that_leave_at_any_moment_do_no_harm(name, tmp_path):
    source = random.Random(7)
    with outlived(name, tmp_path) as emulation:
        with open_driver(name, emulation.address) as driver:
            driver.read(1)
        requests = [message for _, message in emulation.received()]
        for _ in range(LEAVERS):
            messages = source.sample(requests, source.randint(0, len(requests)))
            if messages and source.random() < 0.5:
                last = messages[-1]
                garbled = bytearray(last[: source.randint(1, len(last))])
                garbled[source.randrange(len(garbled))] = source.randrange(256)
                messages[-1] = bytes(garbled)
            leave(name, emulation.address, messages)
            clock.sleep(source.choice([0.0, 1e-4, 0.01]))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["franka", "ur", "xarm", "feetech"])
def test_a_client_that_reads_nothing_does_no_harm(name, tmp_path):
    with outlived(name, tmp_path) as emulation, open_driver(name, emulation.address) as driver:
        driver.read(1)
        requests = [message for _, message in emulation.received()]
        clock.sleep(20)
        if name == "feetech":
            for _ in range(2000):
                leave(name, emulation.address, requests)
                clock.sleep(0.001)


@by_table("name", "message")
def test_a_request_that_makes_no_sense_does_no_harm(name, message, tmp_path):
    with outlived(name, tmp_path) as emulation:
        host, _, port = emulation.address.partition(":")
        if name == "ur":
            with socket.create_connection((host, int(port))) as client:
                client.sendall(bytes.fromhex(message))
                clock.sleep(0.1)
        else:
            leave(name, emulation.address, [bytes.fromhex(message)])


def test_the_help_names_the_controllers_of_a_fault_that_some_lack():
    for kind, words in emulators.KINDS.items():
        faults = {name: getattr(emulators, EMULATORS[name]).FAULTS for name in EMULATORS}
        having = sorted(name for name in faults if kind in faults[name])
        if having != sorted(EMULATORS):
            assert words.endswith(f"({', '.join(having)})"), kind
