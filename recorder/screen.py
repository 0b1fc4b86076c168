"""The recorder's screen: from what is known at one moment to lines of text, and nothing else."""

import math
import textwrap
import time
from dataclasses import dataclass

from rich.console import Group
from rich.text import Text

from .samples import Sample
from .session import JointLimits, Session

__all__ = ["View", "render"]

KEYS = "space capture  d undo  s next  0-9 socket  q finish  ? help"
HELP = """\
space, a    capture: average the last moment, in which the arm must be still
d, u        undo the last capture; its line stays in the file, marked
s           next socket; 0 to 9 go to that socket
q           finish; everything is on the disk already
?           this help; any key leaves it, and does what it does

Guide the arm with the ball in the socket, turn and tilt it as far as it goes,
let go where the arm holds itself, and capture. Vary every joint: the bars
show, within the limits, the range that this socket's samples cover, and where
the joint is now.

Refused: an arm that moves; a stream that is silent, stale, frozen or broken;
a configuration outside the limits, or within 1 degree of an earlier one on
every joint.
Ctrl-C ends the session too. The same --out continues it."""

# Three rows a digit, five half-rows high.
_DIGITS = (
    ("█▀█", "█ █", "▀▀▀"),
    ("▀█ ", " █ ", "▀▀▀"),
    ("▀▀█", "█▀▀", "▀▀▀"),
    ("▀▀█", " ▀█", "▀▀▀"),
    ("█ █", "▀▀█", "  ▀"),
    ("█▀▀", "▀▀█", "▀▀▀"),
    ("█▀▀", "█▀█", "▀▀▀"),
    ("▀▀█", "  █", "  ▀"),
    ("█▀█", "█▀█", "▀▀▀"),
    ("█▀█", "▀▀█", "▀▀▀"),
)
_COLOURS = ("blue", "magenta", "dark_green", "dark_orange3")
_PLAIN = str.maketrans(dict(zip("█▀▒─├┤┃°·…→", "##=-[]|d.~>", strict=True)))
_SMALLEST = (40, 12)


@dataclass(frozen=True)
class View:
    """What is known at one moment: all that the screen shows."""

    session: Session
    title: str
    position: tuple[float, ...] | None = None
    """Joint positions of the last state that was not faulty [rad], [m]; None before the first."""
    trouble: str | None = None
    """Why nothing can be captured now; None when it can."""
    push: str | None = None
    """What shows that the arm is being pushed; None if nothing does."""
    rate: float = 0.0
    """States per second."""
    age: float = math.inf
    """Time since the last state [s]."""
    missed: int = 0
    """States that were lost on the way."""
    drops: int = 0
    """How often the connection was lost."""
    discarded: int = 0
    """Messages that the driver could not use."""
    help: bool = False
    """Whether to show the help in place of joints and captures."""
    scripted: bool = False
    """Whether a script presses the keys."""


def render(view: View, width: int, height: int, *, plain: bool = False) -> Group:
    """Draw a view.

    Args:
        view: What is known.
        width: Columns of the terminal.
        height: Rows of the terminal; as many lines are drawn, unless it is tiny.
        plain: Draw with ASCII only.
    """
    if width < _SMALLEST[0] or height < _SMALLEST[1]:
        return Group(Text(f"too small: {width} x {height}"[:width]))
    top = [_title(view, width), *_banner(view, width), *_counts(view.session, width), _stream(view)]
    bottom = [Text(_fit(KEYS, width), style="bold")]
    middle = _help(width) if view.help else _middle(view, width, height - len(top) - len(bottom))
    room = height - len(top) - len(bottom)
    lines = [*top, *(middle + [Text()] * room)[:room], *bottom]
    for line in lines:
        line.no_wrap = True
        if not line.plain.isprintable():  # what a driver said may hold anything
            line.plain = "".join([c if c.isprintable() else "?" for c in line.plain])
        if plain:
            line.plain = line.plain.translate(_PLAIN)
        line.truncate(width)
    return Group(*lines)


def _title(view: View, width: int) -> Text:
    words = f" mukca record  {view.title}{'  keys by script' if view.scripted else ''}"
    return Text(_fit(words, width).ljust(width), style="reverse")


def _banner(view: View, width: int) -> list[Text]:
    """The active socket, large, and whether a key press would capture."""
    session = view.session
    style = f"bold white on {_COLOURS[session.socket % len(_COLOURS)]}"
    says = _readiness(view, width - 26)
    lines: list[Text] = []
    for row, word in enumerate(("", f"SOCKET {session.socket}", "")):
        big = "  ".join(_DIGITS[int(digit)][row] for digit in str(session.socket))
        line = Text().append(f"  {big}  {word:<12}", style=style).append("  ")
        line.append(*says[row])
        lines.append(line)
    return lines


def _readiness(view: View, width: int) -> list[tuple[str, str]]:
    """Three lines beside the socket's number: whether to wait, why, and how many captures."""
    done = view.session.counts[view.session.socket]
    count = f"{done} of {view.session.target} captured in this socket"
    if view.trouble:
        why = textwrap.wrap(view.trouble, width) or [""]
        second = why[1] if len(why) > 1 else count
        return [("WAIT", "bold yellow"), (why[0], "yellow"), (second, "")]
    if view.push:
        return [
            ("LET GO of the arm: it is being pushed", "bold red"),
            (view.push, "red"),
            (count, ""),
        ]
    return [("STILL: press space", "bold green"), ("", ""), (count, "")]


def _counts(session: Session, width: int) -> list[Text]:
    """Captures of every socket against the target."""
    each = max(16, width // session.sockets)
    line = Text()
    for socket, count in enumerate(session.counts):
        share = min(1.0, count / max(1, session.target))
        length = max(4, each - 18)
        bar = ("█" * round(share * length)).ljust(length, "·")
        style = "bold" if socket == session.socket else ""
        line.append(f" {socket}: {count:>2}/{session.target:<2} {bar}".ljust(each), style=style)
    return [line]


def _stream(view: View) -> Text:
    age = f"{view.age * 1e3:.0f} ms" if view.age < 1 else f"{view.age:.1f} s"
    came = f"last state {age} ago" if math.isfinite(view.age) else "no state yet"
    lost = f"  discarded {view.discarded}" if view.discarded else ""
    lost += f"  connection lost {view.drops}x" if view.drops else ""
    line = Text(f" stream {view.rate:.0f} Hz  {came}  missed {view.missed}{lost}")
    if view.age > 0.25:
        line.stylize("bold red")
    return line


def _middle(view: View, width: int, room: int) -> list[Text]:
    """Joints, last captures and messages, as many as there is room for."""
    joints = _joints(view, width)
    room -= len(joints)
    messages = _messages(view.session, width, max(2, room // 2))
    captures = _captures(view.session, width, max(1, room - len(messages)))
    return [*joints, *captures, *messages]


def _joints(view: View, width: int) -> list[Text]:
    names = max(len(joint.name) for joint in view.session.joints)
    names = min(names, max(10, width // 4))
    values = view.position or (math.nan,) * len(view.session.joints)
    rows = zip(view.session.joints, values, view.session.covered, strict=True)
    return [_joint(joint, value, covered, names, width) for joint, value, covered in rows]


def _joint(
    joint: JointLimits, value: float, covered: tuple[float, float] | None, names: int, width: int
) -> Text:
    """One joint: its range from limit to limit, what is covered of it, and where it is."""
    lower, upper = _ends(joint)
    length = width - names - 30
    line = Text(f" {_fit(joint.name, names):<{names}} ")
    line.append(f"{joint.shown(lower):>8}├", style="dim")

    def column(position: float) -> int:
        share = (position - lower) / (upper - lower)
        return min(length - 1, max(0, round(share * (length - 1))))

    bar = Text("─" * length, style="dim")
    if covered:
        first, last = column(covered[0]), column(covered[1])
        bar = bar[:first] + Text("▒" * (last - first + 1), style="cyan") + bar[last + 1 :]
    if math.isfinite(value):
        here = column(value)
        near = min(value - lower, upper - value) < 0.05 * (upper - lower)
        marker = Text("┃", style="bold red" if near else "bold")
        bar = bar[:here] + marker + bar[here + 1 :]
    line.append_text(bar)
    line.append(f"┤{joint.shown(upper):<8}", style="dim")
    line.append(f"{joint.shown(value):>8}" if math.isfinite(value) else "       -", style="bold")
    return line


def _ends(joint: JointLimits) -> tuple[float, float]:
    """The ends of a joint's bar; one turn for a joint without limits."""
    lower = joint.lower if math.isfinite(joint.lower) else -math.pi
    upper = joint.upper if math.isfinite(joint.upper) else math.pi
    return (lower, upper) if upper > lower else (lower - 0.5, lower + 0.5)


def _captures(session: Session, width: int, room: int) -> list[Text]:
    """The last samples that count, the newest first."""
    newest = session.live[::-1][:room]
    lines = [Text(_fit(_capture(session, sample), width)) for sample in newest]
    return lines or [Text(" no capture yet", style="dim")]


def _capture(session: Session, sample: Sample) -> str:
    clock = "" if sample.time is None else time.strftime("%H:%M:%S", time.localtime(sample.time))
    text = f" sample {sample.number:>3}  socket {sample.socket}  {clock}  {sample.states} states"
    if not sample.spread:
        return text
    worst = max(range(len(sample.spread)), key=sample.spread.__getitem__)
    joint = session.joints[worst]
    spread = sample.spread[worst]
    size = f"{spread * 1e3:.3f} mm" if joint.prismatic else f"{math.degrees(spread):.4f}°"
    return f"{text}  spread {size} ({joint.name})"


def _messages(session: Session, width: int, room: int) -> list[Text]:
    """The last messages, the newest at the end and in full."""
    lines: list[Text] = []
    for message in session.messages[: -room - 1 : -1]:
        mark = "!" if message.alarm else ">"
        if lines:
            parts, style = [_fit(message.text, width - 4)], "dim"
        else:
            parts = textwrap.wrap(message.text, width - 4)[:room]
            style = "bold red" if message.alarm else ""
        lines = [*(Text(f" {mark} {part}", style=style) for part in parts), *lines]
    return lines[-room:]


def _help(width: int) -> list[Text]:
    return [Text(_fit(" " + line, width)) for line in HELP.splitlines()]


def _fit(text: str, width: int) -> str:
    return text if len(text) <= width else text[: max(0, width - 1)] + "…"
