"""Things that listen at a TCP port and are no robot."""

import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager


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
        client, _ = server.accept()
        try:
            with client:
                while texts:
                    for text in texts:
                        client.sendall(text)
                        time.sleep(pause)
                time.sleep(30)
        except OSError:
            return

    threading.Thread(target=serve, daemon=True).start()
    yield f"127.0.0.1:{server.getsockname()[1]}"
    server.close()
