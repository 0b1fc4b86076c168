"""A peer that speaks rosbridge's JSON over a websocket, and publishes joint states.

As a program it takes the options of ``mukca emulate``: ``--address``, ``--fault``, ``--journal``.
"""

import argparse
import itertools
import json
import math
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import ServerConnection, serve

from mukca.drivers import JointState
from mukca.drivers.arms import Fault
from mukca.tools.emulators import KINDS, FaultInjector, Journal

NAMES = ("gripper", "arm_2", "arm_1", "arm_3")  # an order of its own, and a joint too many
ARM = ("arm_1", "arm_2", "arm_3")


@dataclass
class Rosbridge:
    """A rosbridge of one topic."""

    address: str = ""
    topic: str = "/joint_states"
    received: list[dict[str, Any]] = field(default_factory=list)
    odd_messages: list[dict[str, Any]] = field(default_factory=list)
    """Sent once before each state."""
    others: Callable[[int], list[dict[str, Any]]] = lambda _: []
    """Messages of another publisher before the n-th state."""
    pause: float = 0.005
    """Time between two states [s]."""
    first_messages: list[dict[str, Any]] = field(default_factory=list)
    """Sent before all states."""
    clients: list[ServerConnection] = field(default_factory=list)
    faults: Sequence[Fault] = ()
    """By the time since it began."""
    journal: Journal = field(default_factory=lambda: Journal(None))
    host: str = "127.0.0.1"
    port: int = 0
    begun: float = field(default_factory=time.monotonic)

    def handle(self, client):
        self.clients.append(client)
        with suppress(ConnectionClosed):
            for text in client:
                message = json.loads(text)
                self.received.append(message)
                if message["op"] == "subscribe" and message["topic"] == self.topic:
                    threading.Thread(target=self.publish, args=(client,), daemon=True).start()

    def publish(self, client):
        waiting = list(self.first_messages)
        injector = FaultInjector(self.faults, seed=0)
        with suppress(ConnectionClosed):
            for number in itertools.count():
                state = joint_state(number)
                self.journal.sent(number, JointState(0, state["position"], state["effort"]))
                messages = (*waiting, *self.odd_messages, *self.others(number), state)
                for message in messages:
                    text = {"op": "publish", "topic": self.topic, "msg": message}
                    whole = (0, json.dumps(text).encode())
                    for _, part in injector.packets(whole, time.monotonic() - self.begun):
                        client.send(part.decode(errors="replace"))
                waiting.clear()
                time.sleep(self.pause)


def joint_state(number):
    """Return the number-th message: a joint's angle tells which joint it is."""
    sway = 0.01 * math.sin(number / 50)
    return {
        "header": {"stamp": {"sec": number // 200, "nanosec": number % 200 * 5_000_000}},
        "name": list(NAMES),
        "position": [9.0 + sway, 0.2 + sway, 0.1 + sway, 0.3 + sway],
        "velocity": [],
        "effort": [0.0, 20.0, 10.0, 30.0],
    }


def arm_state(number):
    """Return the arm's positions and efforts in the number-th message."""
    message = joint_state(number)
    order = [NAMES.index(name) for name in ARM]
    positions, efforts = message["position"], message["effort"]
    return tuple(positions[i] for i in order), tuple(efforts[i] for i in order)


@contextmanager
def rosbridge(**settings):
    """Run a rosbridge on a free port."""
    bridge = Rosbridge(**settings)
    with serve(bridge.handle, bridge.host, bridge.port) as server:
        host, port = server.socket.getsockname()
        bridge.address = f"{host}:{port}"
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield bridge
        server.shutdown()
        thread.join(10)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--address", default="127.0.0.1:0")
    parser.add_argument("--fault", action="append", default=[])
    parser.add_argument("--journal", type=Path)
    options = parser.parse_args()
    host, _, port = options.address.partition(":")
    faults = [Fault.parse(text, KINDS, math.inf) for text in options.fault]
    with rosbridge(
        faults=faults, journal=Journal(options.journal), host=host, port=int(port)
    ) as bridge:
        print(json.dumps({"driver": f"ros:{bridge.address}"}), flush=True)
        threading.Event().wait()
