"""A Heron to try things with: ``python -m mukca_heron.simulator [HOST [PORT]]``."""

import math
import socket
import sys
import threading
import time

PERIOD = 0.005


def state_line(number: int) -> bytes:
    """Return the line of a state: the arm sways slowly."""
    moment = number * PERIOD
    angles = [10.0 * joint + 5.0 * math.sin(moment / 3 + joint) for joint in range(4)]
    torques = [2.0 * joint for joint in range(4)]
    numbers = " ".join(f"{value:.9g}" for value in (moment, *angles, *torques))
    return f"STATE {number} {numbers}\n".encode()


def serve(server: socket.socket) -> None:
    """Stream to everyone who connects, until the server socket is closed."""
    while True:
        try:
            client, _ = server.accept()
        except OSError:
            return
        threading.Thread(target=stream, args=(client,), daemon=True).start()


def stream(client: socket.socket) -> None:
    """Greet, and send states until the client leaves."""
    start = time.monotonic()
    try:
        with client:
            client.sendall(b"HERON 4\n")
            for number in range(sys.maxsize):
                client.sendall(state_line(number))
                time.sleep(max(0.0, start + number * PERIOD - time.monotonic()))
    except OSError:
        return


if __name__ == "__main__":
    host = sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1"
    port = int(sys.argv[2]) if len(sys.argv) > 2 else 5005
    serve(socket.create_server((host, port)))
