"""Any arm in ROS 1 or 2: ``sensor_msgs/JointState`` through a rosbridge, subscribed to.

Joints are matched by name; messages without any of them, as of a gripper, do not count. Efforts
have the topic's unit and sign (``effort=-1`` turns it); None where a joint has none, NaN or null.
Lost messages cannot be counted: ROS 2 does not number them.

Address: ``HOST[:PORT][?topic=/joint_states&effort=-1]``; PORT is 9090 by default.
"""

import logging
import math
import queue
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

from .. import (
    JointNames,
    JointState,
    JointValues,
    ModelNames,
    Reason,
    ValidatingDriver,
    clock,
    require_finite,
)
from ..transport import Endpoint, open_tcp, parse_endpoint

if TYPE_CHECKING:
    import roslibpy

PORT = 9090
CONNECT_SECONDS = 5.0
FIRST_STATE_SECONDS = 3.0
LISTENING_SECONDS = (
    0.3  # time in which the joints of all publishers are seen, without a model
)
LONGEST_QUEUE = 10_000  # messages that wait for a late reader
LATEST = (
    40  # messages of which so many are counted that are not later than the one before
)
MOST_LATE = 8
UNSTAMPED = "the headers have no stamps: times of arrival are taken"
TWICE = "many messages are not later than the one before: do two publishers send these joints?"


def decode_message(message: Any, joint_names: Sequence[str], sign: int) -> JointState:
    """Return the state of the named joints in a JointState message, parsed from its JSON."""
    try:
        names = list(message["name"])
        lost = [name for name in joint_names if name not in names]
        if lost:
            raise ValueError(f"a message without {', '.join(lost)}")
        order = [names.index(name) for name in joint_names]
        position = _numbers(message["position"], order, len(names))
        effort = _numbers(
            message.get("effort") or [None] * len(names), order, len(names)
        )
        time = message["header"]["stamp"]
        # ROS 2 and 1 name its parts differently.
        keys = ("sec", "nanosec") if "sec" in time else ("secs", "nsecs")
        stamp = float(time[keys[0]]) + 1e-9 * float(time[keys[1]])
    except (AttributeError, KeyError, IndexError, OverflowError, TypeError) as error:
        raise ValueError(f"a message that is no JointState: {error!r}") from None
    require_finite((*position, stamp), "a message with values")
    finite = all(map(math.isfinite, effort))
    return JointState(
        stamp, position, tuple(sign * e for e in effort) if finite else None
    )


class Ros(ValidatingDriver):
    """A subscription to a topic with joint states."""

    def __init__(self, address: str, joint_names: ModelNames = None) -> None:
        endpoint = parse_endpoint(
            address.removeprefix("ws://"),
            PORT,
            ("topic", "effort"),
            default_host="localhost",
        )
        self._sign = endpoint.options.sign("effort")
        topic = endpoint.options.get("topic", "/joint_states")
        super().__init__(f"{topic} of the rosbridge at {endpoint}")
        self._messages: queue.Queue[tuple[float, Any]] = queue.Queue(LONGEST_QUEUE)

        def put(message: Any) -> None:
            try:
                self._messages.put_nowait((clock.now(), message))
            except queue.Full:
                self.missed += 1

        self._client, self._topic = _subscribe(endpoint, topic, put)
        self._ended = threading.Event()
        self._unstamped = False
        self._late: deque[bool] = deque(maxlen=LATEST)
        self._stamp_before = -math.inf
        self._client.on("close", lambda *_: self._ended.set())
        with self._closed_on_error():
            self._joint_names = self._match(joint_names)

    def _receive(self, deadline: float) -> JointState:
        others: JointNames = ()
        while came := self._get(deadline):
            arrival, message = came
            names = _names(message)
            if not names or set(names) & set(self._joint_names):
                return self._state(arrival, message)
            others = names
        if self._ended.is_set():
            raise Reason.UNREACHABLE(f"the connection to {self._where} is lost")
        instead = f", only messages of {', '.join(others)}" if others else ""
        raise self._silence(deadline, "joint states", instead)

    def _state(self, arrival: float, message: Any) -> JointState:
        """Return the state of a message, and keep count of those that are not later."""
        state = decode_message(message, self._joint_names, self._sign)
        if state.stamp == 0 and math.isinf(self._last_stamp):  # the first state of all
            self._unstamped = True
        if self._unstamped:
            self.status = UNSTAMPED
            return replace(state, stamp=arrival)
        self._late.append(state.stamp <= self._stamp_before)
        self._stamp_before = state.stamp
        self.status = TWICE if sum(self._late) >= MOST_LATE else ""
        return state

    def _disconnect(self) -> None:
        if not self._ended.is_set():
            self._topic.unsubscribe()
            self._client.close()

    def _match(self, joint_names: ModelNames) -> JointNames:
        """Wait for a message that has the model's joints, or any joints without a model."""
        deadline = clock.now() + FIRST_STATE_SECONDS
        published: set[str] = set()
        longest: JointNames = ()
        while came := self._get(deadline):
            names = _names(came[1])
            published.update(names)
            if joint_names is not None and set(names) >= set(joint_names):
                return tuple(joint_names)
            if joint_names is None and len(names) > len(longest):
                deadline = min(deadline, clock.now() + LISTENING_SECONDS)
                longest = names
        if longest:
            return longest
        if not published:
            raise Reason.UNREACHABLE(f"nobody publishes on {self._where}")
        lost = [name for name in joint_names or () if name not in published]
        raise Reason.WRONG_ROBOT(
            f"{self._where} has no joint {', '.join(lost) or 'states with all joints at once'}; "
            f"it has {', '.join(sorted(published))}"
        )

    def _get(self, deadline: float) -> tuple[float, Any] | None:
        """Return the next message, and when it came [s]."""
        try:
            return self._messages.get(timeout=clock.left(deadline))
        except queue.Empty:
            return None


def _subscribe(
    endpoint: Endpoint, topic: str, callback: Callable[[Any], None]
) -> "tuple[roslibpy.Ros, roslibpy.Topic]":
    """Connect to a rosbridge and subscribe to a topic."""
    try:
        import roslibpy
    except ImportError:
        raise Reason.MISSING_PACKAGE(
            "ros needs roslibpy: pip install 'mukca[ros]'"
        ) from None
    _keep_quiet()
    open_tcp(
        endpoint, "is rosbridge running (ros2 launch rosbridge_server ...)?"
    ).close()
    client = roslibpy.Ros(endpoint.host, endpoint.port)
    try:
        client.run(timeout=CONNECT_SECONDS)
    except Exception as error:
        raise Reason.PROTOCOL(
            f"what listens at {endpoint} is no rosbridge: {error}"
        ) from None
    finally:
        client.factory.stopTrying()  # a lost connection is made again above, subscription and all
    subscription = roslibpy.Topic(client, topic, "sensor_msgs/JointState")
    subscription.subscribe(callback)
    return client, subscription


@cache
def _keep_quiet() -> None:
    """Keep what these packages log off the screen, for those who did not ask for it."""
    from twisted.logger import globalLogBeginner

    globalLogBeginner.beginLoggingTo((), redirectStandardIO=False)
    for name in ("autobahn", "roslibpy", "twisted"):
        logging.getLogger(name).addHandler(logging.NullHandler())


def _names(message: Any) -> JointNames:
    try:
        return tuple(map(str, message["name"]))
    except (KeyError, TypeError):
        return ()


def _numbers(values: Sequence[Any], order: Sequence[int], count: int) -> JointValues:
    """Return the numbers at the given places of a list of a given length; NaN where it has none."""
    if len(values) != count:
        raise ValueError(f"a message with {count} names and {len(values)} values")
    return tuple(math.nan if values[i] is None else float(values[i]) for i in order)
