"""Things that listen at a TCP port and are no robot."""

import socket
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress


@contextmanager
def answering(answer: bytes) -> Iterator[str]:
    """Something at a port that answers whatever it is asked with the same bytes."""
    server = socket.create_server(("127.0.0.1", 0))

    def serve():
        while True:
            try:
                client, _ = server.accept()
            except OSError:
                return
            with client:
                client.recv(4096)
                client.sendall(answer)
                time.sleep(3 if len(answer) < 15 else 0.2)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    yield f"127.0.0.1:{server.getsockname()[1]}"
    server.shutdown(socket.SHUT_RDWR)
    server.close()


@contextmanager
def saying(*texts: bytes, pause: float = 0.0) -> Iterator[str]:
    """A server that sends each text again and again, whatever it hears."""
    server = socket.create_server(("127.0.0.1", 0))

    def serve():
        with suppress(OSError), server.accept()[0] as client:
            while texts:
                for text in texts:
                    client.sendall(text)
                    time.sleep(pause)
            client.recv(1)  # until it leaves

    threading.Thread(target=serve, daemon=True).start()
    yield f"127.0.0.1:{server.getsockname()[1]}"
    server.close()


@contextmanager
def rtde_controller(*packages: bytes) -> Iterator[str]:
    """A CB3 controller (125 Hz) that sends these packages, all at once, when it is started."""
    server = socket.create_server(("127.0.0.1", 0))
    replies = {
        b"V": b"\1",
        b"v": struct.pack(">4I", 3, 15, 0, 0),
        b"O": b"\1DOUBLE,VECTOR6D,INT32,INT32",
        b"S": b"\1",
    }

    def serve():
        with suppress(OSError), server.accept()[0] as client:
            while request := client.recv(4096):
                kind = request[2:3]
                reply = rtde_package(kind, replies[kind])
                client.sendall(reply + b"".join(packages if kind == b"S" else ()))

    threading.Thread(target=serve, daemon=True).start()
    yield f"127.0.0.1:{server.getsockname()[1]}"
    server.close()


@contextmanager
def fci_robot(*datagrams: bytes, version: int = 5) -> Iterator[str]:
    """A Franka that sends these datagrams once it is connected to."""
    server = socket.create_server(("127.0.0.1", 0))

    def serve():
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        with suppress(OSError), udp, server.accept()[0] as client:
            host = client.getpeername()[0]
            udp.bind(("127.0.0.1", 0))
            port = struct.unpack_from("<H", client.recv(16), 14)[0]
            client.sendall(struct.pack("<IIIBH", 0, 0, 15, 0, version))
            for datagram in datagrams:
                udp.sendto(datagram, (host, port))
            client.recv(1)  # until it leaves

    threading.Thread(target=serve, daemon=True).start()
    yield f"127.0.0.1:{server.getsockname()[1]}"
    server.close()


def robot_state(number: int) -> bytes:
    """A RobotState of FCI version 5: seven torques of 1 to 7 N m, angles of 0.1 to 0.7 rad."""
    datagram = bytearray(2373)
    struct.pack_into("<Q", datagram, 0, number)
    struct.pack_into("<7d", datagram, 1016, *range(1, 8))
    struct.pack_into("<7d", datagram, 1184, *(0.1 * joint for joint in range(1, 8)))
    struct.pack_into("<Bd", datagram, len(datagram) - 9, 3, 1.0)  # guiding
    return bytes(datagram)


def rtde_package(kind: bytes, payload: bytes = b"") -> bytes:
    """A package of RTDE."""
    return struct.pack(">H", 3 + len(payload)) + kind + payload


def fri_message(
    sequence: int, joints: tuple[float, ...], session: int, multiplier: int, milliseconds: int
) -> bytes:
    """A monitoring message of FRI 1.15, without torques."""
    values = b"".join(b"\x09" + struct.pack("<d", q) for q in joints)
    stamp = _fields({1: milliseconds // 1000, 2: milliseconds % 1000 * 10**6})
    body = _nested(1, _fields({1: 0x245142, 2: sequence, 3: 0}))
    body += _nested(3, _nested(1, values) + _nested(15, stamp))
    return body + _nested(4, _fields({1: session, 2: 3, 3: 5, 4: multiplier}))


def _fields(numbers: dict[int, int]) -> bytes:
    return b"".join(_varint(number << 3) + _varint(value) for number, value in numbers.items())


def _nested(number: int, message: bytes) -> bytes:
    return _varint(number << 3 | 2) + _varint(len(message)) + message


def _varint(value: int) -> bytes:
    head = bytearray()
    while value >= 1 << 7:
        head.append(1 << 7 | value & 127)
        value >>= 7
    return bytes([*head, value])
