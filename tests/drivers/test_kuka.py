"""KUKA's FRI: the reply's bytes, when it is due, and the sequence of messages."""

import socket
import zlib
from itertools import count

import pytest
from driver_errors import read_until_silent, refused
from emulation import emulated
from emulator_programs import own_host
from listeners import fri_message
from virtual_time import CARRIED, Every

from mukca import open_driver

pytestmark = pytest.mark.waits

Q = (0.1, -0.2, 0.3, -0.4, 0.5, -0.6, 0.7)


@pytest.mark.parametrize("version", ["1.11", "1.14", "1.15", "1.16", "2.5", "2.7"])
def test_the_replies_bytes(version, tmp_path):
    """A header of command id 0x34001, as the vendor's client of 1.15 and 2.7 sends it."""
    with emulated("kuka", tmp_path, "--version", version) as emulation:
        with open_driver("kuka", emulation.address) as driver:
            assert driver.status == "monitoring wait, excellent"
            stamp = driver.read(1).stamp
            driver.read(1)
        reply = emulation.received()[0][1]
    sent = round((stamp - 1_700_000_000) * 200)  # reflected
    bare = bytes.fromhex("0A 08 08 81 80 0D 10 00 18") + bytes([sent])
    framed = len(bare).to_bytes(4, "little") + bare + zlib.crc32(bare).to_bytes(4, "little")
    assert reply == (framed if version == "2.7" else bare)


class Controller:
    """A controller that sends what it is told, one message at a time."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((own_host(), 0))
        self.socket.settimeout(CARRIED)
        self.client = own_host()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind((self.client, 0))
            self.port = free.getsockname()[1]

    @property
    def address(self):
        return f"{self.socket.getsockname()[0]}:{self.port}?bind={self.client}"

    def send(self, sequence, session=2, multiplier=1, joints=Q, stamp=None):
        """The stamp is in ms, by default the sequence number."""
        stamp = sequence if stamp is None else stamp
        message = fri_message(sequence, joints, session, multiplier, stamp)
        self.socket.sendto(message, (self.client, self.port))

    def replies(self):
        replies = []
        try:
            while True:
                replies.append(self.socket.recv(100))
        except TimeoutError:
            return replies


@pytest.fixture
def controller():
    controller = Controller()
    yield controller
    controller.socket.close()


@pytest.fixture
def driver(controller, virtual_time):
    virtual_time.peers.append(Every(virtual_time, 0.2, lambda: controller.send(0)))
    with open_driver("kuka", controller.address) as driver:
        virtual_time.peers.clear()
        driver.read(1)
        controller.replies()
        yield driver


def read_all(driver):
    return [round(state.stamp * 1000) for state in read_until_silent(driver)]


def test_a_reply_to_each_so_many_messages(controller, driver):
    for sequence in range(1, 21):
        controller.send(sequence, multiplier=5)
    assert len(read_all(driver)) == 20
    replies = controller.replies()
    assert replies[0] == bytes.fromhex("0A 08 08 81 80 0D 10 01 18 05")
    assert [reply[-1] for reply in replies] == [5, 10, 15, 20]  # what they reflect
    assert [reply[7] for reply in replies] == [1, 2, 3, 4]  # their own counter, after the first
    for sequence in range(21, 27):
        controller.send(sequence, session=0)
    assert len(read_all(driver)) == 6 and controller.replies() == []  # none when idle


def test_missed_and_late_messages(controller, driver):
    for sequence in (1, 4, 3, 4, 5):
        controller.send(sequence)
    assert read_all(driver) == [1, 4, 5]
    assert (driver.missed, driver.rejected) == (2, 2)


def test_a_new_session_counts_from_the_start(controller, driver):
    for sequence in (1000, 1001, 0, 1, 2):
        controller.send(sequence)
    assert read_all(driver) == [1000, 1001, 0, 1, 2]
    assert driver.missed == 999


def test_the_sign_of_efforts_can_be_kept(tmp_path):
    with emulated("kuka", tmp_path, "--noise", "0") as emulation:
        with open_driver("kuka", emulation.address) as plain:
            turned = plain.read(5).effort
        with open_driver("kuka", f"{emulation.address}&effort=1") as kept:
            assert kept.read(5).effort == pytest.approx([-tau for tau in turned], abs=0.5)


def test_a_port_that_is_taken_is_told():
    host = own_host()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind((host, 0))
        port = other.getsockname()[1]
        with refused("BUSY", match=f"UDP {host}:{port} cannot be opened"):
            open_driver("kuka", f"127.0.0.2:{port}?bind={host}")


def test_a_session_without_joint_angles_is_told(controller, virtual_time):
    sequence = count()
    send = Every(virtual_time, 0.1, lambda: controller.send(next(sequence), 0, 1, ()))
    virtual_time.peers.append(send)
    with refused("WRONG_MODE", match="idle, excellent and tells no joint angles"):
        open_driver("kuka", controller.address)


@pytest.mark.parametrize("count", [1, 6, 8])
def test_another_number_of_joints_in_mid_stream_is_refused(controller, driver, count):
    controller.send(1)
    controller.send(2, joints=(*Q, 0.8)[:count])
    controller.send(3)
    assert read_all(driver) == [1, 3]
    assert driver.rejected == 1


@pytest.mark.parametrize("stamps", [(9, 8, 3, 10), (9, 9, 9, 10), (9, 2**62 // 10**6, 0, 10)])
def test_stamps_that_do_not_grow_as_time_does_are_refused(controller, driver, stamps):
    for sequence, stamp in enumerate(stamps, 1):
        controller.send(sequence, stamp=stamp)
    assert read_all(driver) == [9, 10]
    assert driver.rejected == 2
