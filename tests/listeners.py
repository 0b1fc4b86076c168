"""Things that listen at a TCP port and are no robot."""

import socket
import struct
import threading
import time
from contextlib import contextmanager, suppress

from mukca.drivers.arms.fri import nested, numbers


@contextmanager
def listening(serve, clients=1):
    """Something at a port that serves so many clients, one after the other."""
    server = socket.create_server(("127.0.0.1", 0))

    def accept():
        with suppress(OSError):
            for _ in range(clients):
                with server.accept()[0] as client:
                    serve(client)

    threading.Thread(target=accept, daemon=True).start()
    yield f"127.0.0.1:{server.getsockname()[1]}"
    with suppress(OSError):  # it may have ended
        server.shutdown(socket.SHUT_RDWR)
    server.close()


def answering(answer):
    """Something at a port that answers whatever it is asked with the same bytes."""

    def serve(client):
        with suppress(OSError):
            client.recv(4096)
            client.sendall(answer)
            time.sleep(3 if len(answer) < 15 else 0.2)

    return listening(serve, clients=1000)


def saying(*texts, pause=0.0):
    """A server that sends each text again and again, whatever it hears."""

    def serve(client):
        while texts:
            for text in texts:
                client.sendall(text)
                time.sleep(pause)
        client.recv(1)  # until it leaves

    return listening(serve)


def rtde_controller(*packages):
    """A CB3 controller (125 Hz) that sends these packages, all at once, when it is started."""
    replies = {
        b"V": b"\1",
        b"v": struct.pack(">4I", 3, 15, 0, 0),
        b"O": b"\1DOUBLE,VECTOR6D,INT32,INT32",
        b"S": b"\1",
    }

    def serve(client):
        while request := client.recv(4096):
            kind = request[2:3]
            reply = rtde_package(kind, replies[kind])
            client.sendall(reply + b"".join(packages if kind == b"S" else ()))

    return listening(serve)


def fci_robot(*datagrams, version=5):
    """A Franka that sends these datagrams once it is connected to."""

    def serve(client):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
            host = client.getpeername()[0]
            udp.bind(("127.0.0.1", 0))
            port = struct.unpack_from("<H", client.recv(16), 14)[0]
            client.sendall(struct.pack("<IIIBH", 0, 0, 15, 0, version))
            for datagram in datagrams:
                udp.sendto(datagram, (host, port))
            client.recv(1)  # until it leaves

    return listening(serve)


def robot_state(number):
    """A RobotState of FCI version 5: seven torques of 1 to 7 N m, angles of 0.1 to 0.7 rad."""
    datagram = bytearray(2373)
    struct.pack_into("<Q", datagram, 0, number)
    struct.pack_into("<7d", datagram, 1016, *range(1, 8))
    struct.pack_into("<7d", datagram, 1184, *(0.1 * joint for joint in range(1, 8)))
    struct.pack_into("<Bd", datagram, len(datagram) - 9, 3, 1.0)  # guiding
    return bytes(datagram)


def rtde_package(kind, payload=b""):
    """A package of RTDE."""
    return struct.pack(">H", 3 + len(payload)) + kind + payload


def fri_message(sequence, joints, session, multiplier, milliseconds):
    """A monitoring message of FRI 1.15, without torques."""
    values = b"".join(b"\x09" + struct.pack("<d", q) for q in joints)
    stamp = numbers({1: milliseconds // 1000, 2: milliseconds % 1000 * 10**6})
    body = nested(1, numbers({1: 0x245142, 2: sequence, 3: 0}))
    body += nested(3, nested(1, values) + nested(15, stamp))
    return body + nested(4, numbers({1: session, 2: 3, 3: 5, 4: multiplier}))
