"""KUKA's FRI: the reply's bytes, when it is due, and the sequence of messages."""

import socket
import struct
import time
from itertools import count

import pytest
from emulation import emulated, own_host
from virtual_time import Every

from mukca.drivers import DriverError, JointState, Reason
from mukca.drivers.arms.fri import Session, decode_message, encode_reply
from mukca.drivers.arms.kuka import Kuka
from mukca.tools.emulators.kuka import encode_message, nested, numbers, varint

Q = (0.1, -0.2, 0.3, -0.4, 0.5, -0.6, 0.7)
TAU = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
STATE = JointState(0.0, Q, TAU)
READY = (2, 3, 5, 1)


def test_the_replies_bytes():
    """A header of command id 0x34001, as the vendor's client of 1.15 and 2.7 sends it."""
    bare = bytes.fromhex("0A 08 08 81 80 0D 10 00 18 05")
    assert encode_reply(0, 5, framed=False) == bare
    framed = bytes.fromhex("0A 00 00 00") + bare + bytes.fromhex("74 4B BC F6")
    assert encode_reply(0, 5, framed=True) == framed


def test_a_replys_large_counters():
    reply = encode_reply(300, 2**32 - 1, framed=False)
    assert reply == bytes.fromhex("0A 0D 08 81 80 0D 10 AC 02 18 FF FF FF FF 0F")


@pytest.mark.parametrize("version", ["1.11", "1.14", "1.15", "1.16", "2.5", "2.7"])
def test_a_message(version):
    message = encode_message(version, (0x245142, 9, 8), (2, 1, 5, 3), STATE, 1_500_000_000)
    decoded = decode_message(message)
    assert decoded.position == Q
    assert decoded.torque == TAU
    assert (decoded.sequence, decoded.session) == (9, Session.MONITORING_READY)
    assert (decoded.quality, decoded.receive_multiplier) == ("fair", 3)
    assert decoded.stamp == pytest.approx(1_700_000_001.5)
    assert decoded.framed == (version == "2.7")


def test_joint_values_may_be_packed():
    packed = b"\x0a" + varint(56) + struct.pack("<7d", *Q)
    body = nested(1, numbers({1: 0x245142, 2: 7, 3: 0})) + nested(3, nested(1, packed))
    body += nested(4, numbers({1: 1, 2: 0, 3: 10}))
    decoded = decode_message(body)
    assert decoded.position == Q
    assert decoded.torque is None
    assert decoded.stamp == pytest.approx(0.07)  # seven periods of 10 ms


class Controller:
    """A controller that sends what it is told, one message at a time."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((own_host(), 0))
        self.socket.settimeout(0.3)
        self.client = own_host()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind((self.client, 0))
            self.port = free.getsockname()[1]

    def send(self, sequence, session=2, multiplier=1, state=STATE, stamp=None):
        """The stamp is in ms, by default the sequence number."""
        stamp = sequence if stamp is None else stamp
        message = encode_message(
            "1.15", (0x245142, sequence, 0), (session, 3, 5, multiplier), state, stamp * 10**6
        )
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
    host = controller.socket.getsockname()[0]
    with Kuka(f"{host}:{controller.port}?bind={controller.client}") as driver:
        virtual_time.peers.clear()
        driver.read(1)
        controller.replies()
        yield driver


def read_all(driver):
    stamps = []
    try:
        while True:
            stamps.append(round((driver.read(0.2).stamp - 1_700_000_000) * 1000))
    except DriverError as error:
        assert error.reason is Reason.SILENT
    return stamps


def test_a_reply_to_each_so_many_messages(controller, driver):
    for sequence in range(1, 21):
        controller.send(sequence, multiplier=5)
    assert len(read_all(driver)) == 20
    replies = controller.replies()
    assert [reply[-1] for reply in replies] == [5, 10, 15, 20]  # what they reflect
    assert [reply[7] for reply in replies] == [1, 2, 3, 4]  # their own counter, after the first


def test_no_reply_when_idle(controller, driver):
    for sequence in range(1, 7):
        controller.send(sequence, session=0)
    assert len(read_all(driver)) == 6
    assert controller.replies() == []


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


def test_efforts_can_be_turned(tmp_path):
    with emulated("kuka", tmp_path, "--noise", "0") as emulation:
        with Kuka(emulation.address) as plain:
            as_told = plain.read(5).effort
        with Kuka(f"{emulation.address}&effort=-1") as turned:
            assert turned.read(5).effort == pytest.approx([-tau for tau in as_told], abs=0.5)


def test_a_port_that_is_taken_is_told():
    host = own_host()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind((host, 0))
        port = other.getsockname()[1]
        start = time.monotonic()
        with pytest.raises(DriverError, match=f"UDP {host}:{port} cannot be opened") as caught:
            Kuka(f"127.0.0.2:{port}?bind={host}")
    assert caught.value.reason is Reason.BUSY
    assert time.monotonic() - start < 2


def test_an_address_that_is_not_this_computers_is_told():
    with pytest.raises(DriverError, match="cannot be opened here") as caught:
        Kuka("127.0.0.2?bind=8.8.8.8")
    assert caught.value.reason is Reason.BAD_ADDRESS


def test_a_session_without_joint_angles_is_told(controller, virtual_time):
    empty, sequence = JointState(0.0, (), ()), count()
    send = Every(virtual_time, 0.1, lambda: controller.send(next(sequence), 0, 1, empty))
    virtual_time.peers.append(send)
    host = controller.socket.getsockname()[0]
    with pytest.raises(DriverError, match="idle, excellent and tells no joint angles") as caught:
        Kuka(f"{host}:{controller.port}?bind={controller.client}")
    assert caught.value.reason is Reason.WRONG_MODE


@pytest.mark.parametrize("count", [1, 6, 8])
def test_another_number_of_joints_in_mid_stream_is_refused(controller, driver, count):
    other = JointState(0.0, (*Q, 0.8)[:count], (*TAU, 8.0)[:count])
    controller.send(1)
    controller.send(2, state=other)
    controller.send(3)
    assert read_all(driver) == [1, 3]
    assert driver.rejected == 1


@pytest.mark.parametrize("stamps", [(9, 8, 3, 10), (9, 9, 9, 10), (9, 2**62 // 10**6, 0, 10)])
def test_stamps_that_do_not_grow_as_time_does_are_refused(controller, driver, stamps):
    for sequence, stamp in enumerate(stamps, 1):
        controller.send(sequence, stamp=stamp)
    assert read_all(driver) == [9, 10]
    assert driver.rejected == 2


def monitoring(connection, stamp=b""):
    """A message of FRI 1.15 by its connection info and its stamp."""
    body = nested(1, numbers({1: 0x245142, 2: 7, 3: 0}))
    body += nested(3, nested(1, b"\x0a" + varint(56) + struct.pack("<7d", *Q)) + stamp)
    return body + nested(4, numbers(dict(enumerate(connection, 1))))


def test_a_reply_that_would_never_be_due_is_refused():
    assert decode_message(monitoring((2, 3, 5, 1000))).receive_multiplier == 1000
    with pytest.raises(ValueError, match="wants a reply only to each 1099511627776th"):
        decode_message(monitoring((2, 3, 5, 2**40)))


@pytest.mark.parametrize(("seconds", "nanoseconds"), [(0, 2**62), (0, 10**9), (2**62, 0)])
def test_a_stamp_that_is_no_time_is_refused(seconds, nanoseconds):
    stamp = nested(15, numbers({1: seconds, 2: nanoseconds}))
    with pytest.raises(ValueError, match="an FRI message with a stamp of"):
        decode_message(monitoring((2, 3, 5, 1), stamp))
