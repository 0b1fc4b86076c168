"""Emulated controllers in virtual time, which drivers in this process then live in too."""

import os
from contextlib import contextmanager

import can
import pytest
from emulator_programs import Emulation, emulator_words
from virtual_time import VirtualTime

from mukca.drivers import clock, open_driver
from mukca.tools.cli import build_parser, read_options
from mukca.tools.cli.commands import open_emulator


@contextmanager
def emulated(name, folder, *options):
    """Run an emulator in this process."""
    words, journal = emulator_words(name, folder, options)
    asked = read_options(build_parser("emulate").parse_args(["emulate", *words]))
    with VirtualTime().running() as time, pytest.MonkeyPatch.context() as patch:
        patch.setattr(can, "Bus", VirtualBus)
        VirtualBus.network_is_down = False
        running = _Peer(asked, time)
        try:
            address = running.emulator.driver_address.partition(":")[2]
            yield Emulation(name, address, running, journal)
        finally:
            running.stop()


@contextmanager
def reading(name, folder, *options, settings=""):
    """Run an emulator in this process, and read it by its driver, with settings of the address."""
    emulator = emulated(name, folder, *options)
    with emulator as emulation, open_driver(name, emulation.address + settings) as driver:
        yield emulation, driver


class _Peer:
    """An emulator in this process."""

    def __init__(self, options, time):
        self.emulator = open_emulator(options)
        self._time = time
        time.peers.append(self.emulator)
        self._reader, self._writer = os.pipe()
        if options.wait:
            self.emulator.wait_for_line(self._reader)

    def release(self):
        os.write(self._writer, b"\n")

    def stop(self):
        if self.emulator not in self._time.peers:
            return
        self._time.peers.remove(self.emulator)
        self.emulator.close()
        self.emulator.journal.close()
        os.close(self._reader)
        os.close(self._writer)


_REAL_BUS = can.Bus


class VirtualBus:
    """A CAN bus whose frames come in virtual time."""

    network_is_down = False

    def __init__(self, **settings):
        self._bus = _REAL_BUS(**settings)

    def fileno(self):
        return self._bus.fileno()

    def recv(self, wait):
        if self.network_is_down:
            raise OSError("Network is down")
        end = clock.now() + wait
        while not (frame := self._bus.recv(0)):
            if wait <= 0 or not clock.wait([self._bus], max(0.0, end - clock.now())):
                return None
        frame.timestamp = clock.now()
        return frame

    def send(self, message):
        self._bus.send(message)

    def shutdown(self):
        self._bus.shutdown()
