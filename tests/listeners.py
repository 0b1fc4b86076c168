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
                reply = struct.pack(">H", 3 + len(replies[kind])) + kind + replies[kind]
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
