"""The recorder's screen: a pure function from a view to lines of text."""

import math
import re
import textwrap
import time
from collections.abc import Iterable
from itertools import chain, groupby
from operator import itemgetter
from pathlib import Path

from rich.text import Text

from ...errors import cleaned
from .. import Sample
from ..session import Message, Session, View, all_key_names, with_key_names
from ..stream import JointLimits
from .facts import Texts, fit, gauge, kept, progress_bar, stream

BAR = (
    "{capture} capture  {undo} undo  {redo} redo  {next} next socket  "
    "{finish} finish  {help} all keys"
)
_TEXTS = Path(__file__).parent
_HELP = (_TEXTS / "help.txt").read_text(encoding="utf-8").rstrip("\n")
_PLAIN = str.maketrans(dict(zip("█▀▄▮╷─├┤┃◆▸°·…→", "##=i'-[]|<>d.~>", strict=True)))
_WIDTH, _USUAL = 60, 80
"""Samples in each of two sockets that ENOUGH usually takes."""


def rows_needed(joints: int) -> int:
    """Return the number of rows that show all of an arm's joints, and all of a refusal."""
    return joints + 7


def render(view: View, width: int, height: int, *, ascii_only: bool = False) -> Texts:
    """Return a view as lines of a terminal's width, as many as its height unless it is too small.

    ``ascii_only`` draws with ASCII only.
    """
    if width < _WIDTH or height < rows_needed(len(view.session.joints)):
        lines = _brief(view, width, height)
    else:
        lines = _lines(view, width, height)
    return [_shown(line, width, ascii_only=ascii_only) for line in lines]


def advice_lines(view: View, width: int) -> list[str]:
    """Return the advice in lines, for where there is no screen; none without advice."""
    if not view.advice or not view.advice.is_informative:
        return []
    return [line.plain.strip() for line in (*gauge(view, width), *_hint(view, width))]


def help_lines(view: View) -> list[str]:
    """Return the help, with all keys of each action."""
    names = all_key_names(view.session.keys)
    column = max(12, *(len(name) + 2 for name in names.values()))
    return with_key_names(_HELP, names).expandtabs(column).splitlines()


def _shown(line: Text, width: int, *, ascii_only: bool) -> Text:
    """Return a line that a terminal can show."""
    line.no_wrap = True
    line.plain = re.sub("[\n\t]", " ", cleaned(line.plain))  # a driver may say anything
    if ascii_only:
        line.plain = line.plain.translate(_PLAIN)
    line.truncate(width)
    return line


def _brief(view: View, width: int, height: int) -> Texts:
    """The next step, the counts, and the last message, where the whole screen has no room."""
    session = view.session
    counts = [f"{count} in socket {k}" for k, count in enumerate(session.counts)]
    lowest = rows_needed(len(session.joints))
    needs = f"The whole screen needs {_WIDTH} x {lowest}, not {width} x {height}."
    lines = [
        *_wrapped([f"SOCKET {session.socket}  {view.prompt.text}"], width, "bold"),
        *_wrapped([f"{', '.join(counts)}.", needs], width, ""),
        *_last_message(session, width, height),
    ]
    return [*lines, *[Text()] * height][:height]


def _lines(view: View, width: int, height: int) -> Texts:
    """Return all lines: the less room there is, the fewer of those that are least needed."""
    spare = height - rows_needed(len(view.session.joints))
    names = [
        "mukca record",
        view.page,
        view.title,
        "keys by script" if view.scripted else "",
    ]
    heading = " " + "  ".join(filter(None, names))
    title = Text(fit(heading, width).ljust(width), style="reverse")
    top = [title][: max(0, spare - 1)]
    words = view.large if _fits(view.large, width) else view.prompt.words
    top += banner(words, view.prompt.colour, width)
    top += _status(view, width, max(1, spare - 4))
    top.append(_counts(view.session, width))
    if not view.help:
        predicted, *details = gauge(view, width)
        facts = [*kept(view, width), predicted, stream(view, width), *details]
        top += [line for line in facts if line.plain][: max(0, spare - 2)]
    keys = [Text(fit(_bar(view, width), width), style="bold")][:spare]
    room = height - len(top) - len(keys)
    if view.help:
        page = [f"page        {view.page}"] if view.page else []
        middle = [Text(fit(f" {line}", width)) for line in (*page, *help_lines(view))]
    else:
        middle = _middle(view, width, room)
    middle += [Text()] * room
    return [*top, *middle[:room], *keys]


def _bar(view: View, width: int) -> str:
    """The keys that do something: while the operator is asked, those that answer."""
    answers = view.question.partition("   ")[2] or view.typed.partition("_   ")[2]
    bars = [answers] if answers else [BAR, BAR.replace("{redo} redo  ", "")]
    rows = [view.session.with_keys(bar) for bar in bars]
    return next((row for row in rows if len(row) <= width), rows[-1])


def _wrapped(texts: Iterable[str], width: int, style: str) -> Texts:
    """Return texts in as many lines as they need."""
    lines = chain.from_iterable(
        textwrap.wrap(text, max(1, width - 2)) for text in texts
    )
    return [Text(f" {line}", style=style) for line in lines]


def _status(view: View, width: int, rows: int) -> Texts:
    """The active socket, the banner's words again, and the whole reason, if it fits some lines."""
    start, text = f"SOCKET {view.session.socket}  ", view.prompt.text
    if width < _USUAL and len(start + text) >= width:  # the words stand in the banner
        text = view.prompt.reason
    lines = _wrapped([start + text], width, "bold")
    whole = Text(fit(f" {start}{text}", width), style="bold")
    return lines if len(lines) <= rows else [whole]


def _counts(session: Session, width: int) -> Text:
    """Captures of every socket against the target."""
    column = max(16, width // session.sockets)
    line = Text()
    asked = session.asked
    target = int(asked.rpartition("-")[2])
    length = max(4, column - 16 - len(asked))
    for socket, count in enumerate(session.counts):
        bar = progress_bar(count / max(1, target), length)
        style = "bold" if socket == session.socket else ""
        words = f" {socket}: {count:>2}/{asked:<2} {bar}"
        line.append(words.ljust(column), style=style)
    return line


def _middle(view: View, width: int, room: int) -> Texts:
    """Joints, last captures and messages, as many as there is room for."""
    joints = _joints(view, width)
    if view.resume_summary:
        return [*_wrapped(view.resume_summary, width, "bold"), *joints]
    room -= len(joints)
    hint = _hint(view, width)[: max(0, room - 2)]
    of_messages = min(room // 2, room - len(hint))
    messages = _messages(view.session, width, max(2, of_messages))
    room = max(0, room - len(messages) - len(hint))
    newest = view.session.live[::-1][:room]
    captures = [Text(fit(_capture(view.session, s), width)) for s in newest]
    captures = captures or [Text(" no capture yet", style="dim")][:room]
    return [*joints, *hint, *captures, *messages]


def _hint(view: View, width: int) -> Texts:
    """The next pose in words: each joint that must move, in the order of the chain."""
    advice = view.advice
    if not advice:
        return []
    if advice.enough or advice.exhausted:
        return _wrapped(advice.closing, width, "bold cyan")
    if advice.target is None or view.position is None or advice.leave:
        return []
    turns = [f"{joint.name} {joint.turned(turn)}" for joint, turn in view.turns]
    lift = "lift the ball out for this one: " if advice.lift else ""
    text = f"next best ◆ ({{avoid}}: not here): {lift}{', '.join(turns) or 'here'}"
    return _wrapped([view.session.with_keys(text)], width, "bold cyan")


def _joints(view: View, width: int) -> Texts:
    session = view.session
    longest = max(len(joint.name) for joint in session.joints)
    names = min(longest, max(10, width // 4))
    nowhere = (math.nan,) * len(session.joints)
    values = view.position or nowhere
    target = (view.advice and view.advice.target) or nowhere
    here_last = sorted(session.live, key=lambda sample: sample.socket == session.socket)
    lines: Texts = []
    for i, joint in enumerate(session.joints):
        marks: list[tuple[float, str, str]] = []
        for sample in here_last:
            is_here = sample.socket == session.socket
            mark, style = ("▮", "cyan") if is_here else ("╷", "dim")
            marks.append((sample.position[i], mark, style))
        lower, upper = _ends(joint)
        margin = min(values[i] - lower, upper - values[i])
        at_limit = margin < 0.05 * (upper - lower)
        marks.append((target[i], "◆", "bold magenta"))
        marks.append((values[i], "┃", "bold red" if at_limit else "bold"))
        # Joints of one arm differ by the end of their names.
        name = joint.name if len(joint.name) <= names else f"…{joint.name[1 - names :]}"
        line = Text(f" {name:<{names}} ")
        line.append(_joint(joint, values[i], marks, width - names - 30))
        lines.append(line)
    return lines


def _joint(
    joint: JointLimits, value: float, marks: list[tuple[float, str, str]], length: int
) -> Text:
    """One joint: its range from limit to limit with marks on it, and its position."""
    lower, upper = _ends(joint)
    bar = [("─", "dim")] * length
    for position, mark, style in marks:
        if math.isfinite(position):
            share = (position - lower) / (upper - lower)
            place = round(share * (length - 1))
            bar[min(length - 1, max(0, place))] = (mark, style)
    line = Text().append(f"{joint.shown(lower):>8}├", style="dim")
    for style, run in groupby(bar, key=itemgetter(1)):
        line.append("".join(mark for mark, _ in run), style=style)
    line.append(f"┤{joint.shown(upper):<8}", style="dim")
    line.append(
        f"{joint.shown(value):>8}" if math.isfinite(value) else "       -", style="bold"
    )
    return line


def _ends(joint: JointLimits) -> tuple[float, float]:
    """The ends of a joint's bar; one turn for a joint without limits."""
    lower = joint.lower if math.isfinite(joint.lower) else -math.pi
    upper = joint.upper if math.isfinite(joint.upper) else math.pi
    return (lower, upper) if upper > lower else (lower - 0.5, lower + 0.5)


def _capture(session: Session, sample: Sample) -> str:
    clock = ""
    if sample.time is not None:
        clock = time.strftime("%H:%M:%S", time.localtime(sample.time))
    text = f" sample {sample.number:>3}  socket {sample.socket}  {clock}  {sample.states} states"
    if not sample.spread:
        return text
    spread = max(sample.spread)
    joint = session.joints[sample.spread.index(spread)]
    size = (
        f"{spread * 1e3:.3f} mm" if joint.prismatic else f"{math.degrees(spread):.4f}°"
    )
    return f"{text}  spread {size} ({joint.name})"


def _messages(session: Session, width: int, room: int) -> Texts:
    """The last messages, the newest at the end and in full."""
    before = session.messages[-room:-1]
    texts = [fit(f" {_mark(message)} {message.text}", width - 1) for message in before]
    lines = [Text(text, style="dim") for text in texts]
    return [*lines, *_last_message(session, width, room)][-room:]


def _last_message(session: Session, width: int, room: int) -> Texts:
    """The last message in full, as far as there is room."""
    if not session.messages:
        return []
    message = session.messages[-1]
    style = "bold red" if message.alarm else ""
    parts = textwrap.wrap(message.text, max(1, width - 4))[:room]
    return [Text(f" {_mark(message)} {part}", style=style) for part in parts]


def _mark(message: Message) -> str:
    return "!" if message.alarm else ">"


_ROWS = (_TEXTS / "letters.txt").read_text(encoding="utf-8").split("\n")
_LETTERS = {
    letter: rows
    for i in range(0, len(_ROWS) - 1, 4)
    for letter, *rows in zip(*(row.split("|") for row in _ROWS[i : i + 4]), strict=True)
}
"""Three rows a letter, five half-rows high."""


def _fits(words: str, width: int) -> bool:
    """Return whether a banner has room for some words, and all their letters."""
    is_known = set(words) <= set(_LETTERS)
    return is_known and sum(len(_LETTERS[letter][0]) + 1 for letter in words) <= width


def banner(words: str, colour: str, width: int) -> Texts:
    """Return some words as three lines, each as wide as the screen and all of one colour."""
    letters = [_LETTERS.get(letter, _LETTERS["?"]) for letter in words]
    style = f"bold white on {colour}"
    rows = [" " + " ".join(row) for row in zip(*letters, strict=True)]
    return [Text(row[:width].ljust(width), style=style) for row in rows]
