"""Facts on the screen: what is kept, the predicted error, the stream; none is cut in its midst."""

import math
from collections.abc import Iterable

from rich.text import Text

from ...errors import fixed
from ..session import View

Texts = list[Text]
"""Lines of a screen."""
OLD = 2
"""Samples by which advice may be older before its age is said."""


def kept(view: View, width: int) -> Texts:
    """The faults that are kept, and what a solving will make of them."""
    if not view.kept:
        return []
    advice = view.advice
    solved = "solve tells once there are more samples"
    if advice and advice.fitted:
        solved = "solve says FAIL" if advice.fails else "solve names it and goes on"
    samples = ((a.words, *a.samples, 1) for a in view.kept[-2:])
    faults = ", ".join(f"{words} from sample {n} on" for words, n, *_ in samples)
    return [Text(fit(f" kept: {faults}; {solved}", width), style="bold red")]


def gauge(view: View, width: int) -> Texts:
    """The predicted error against the goal, and what the fit says: a line, or two if need be."""
    advice = view.advice
    if not advice or not advice.is_informative:
        late = " no advice yet: the computer is busy; go on meanwhile"
        return [Text(late if view.late else "", style="bold")]
    older = len(view.session.live) - advice.count
    facts = [
        f"goal {_mm(advice.goal)}",
        f"{older} samples ago" if older > OLD else None,
        _fact("last", advice.last_error),
        _fact("mean", advice.mean_error),
        None
        if advice.scale is None
        else f"scale {fixed(100 * advice.scale, 2, '+')} %",
        _fact("sockets", advice.distance),
    ]
    unit = " mrad" if advice.unit == "mrad" else ""
    start = f" predicted {_mm(advice.predicted)}{unit} "
    first, *lines = _lines_of(facts, width - len(start) - 4)
    length = max(3, min(24, width - len(f"{start} {first}")))
    bar = progress_bar(advice.goal / max(advice.predicted, 1e-9), length)
    style = "green" if advice.predicted <= advice.goal else ""
    top = Text(f"{start}{bar} {first}", style=style)
    return [top, *(Text(f" {line}") for line in lines)]


def _fact(name: str, metres: float | None) -> str | None:
    return None if metres is None else f"{name} {_mm(metres)}"


def _lines_of(facts: Iterable[str | None], width: int) -> list[str]:
    """Return facts in lines, none of which is cut."""
    lines = [""]
    for fact in filter(None, facts):
        joined = f"{lines[-1]} {fact}".strip()
        lines[-1:] = [joined] if len(joined) <= width else [lines[-1], fact]
    return lines


def progress_bar(share: float, length: int) -> str:
    """Return a bar of a length, filled by a share of it."""
    filled = round(min(1.0, share) * length)
    return ("█" * filled).ljust(length, "·")


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.2f}"


def stream(view: View, width: int) -> Text:
    """The stream's state; in fewer words where there is less room."""
    age = f"{view.age * 1e3:.0f} ms" if view.age < 1 else f"{view.age:.1f} s"
    has_state = math.isfinite(view.age)
    drops, rate = view.drops, f"{view.rate:.0f} Hz"
    missed = f"  missed {view.missed}"
    missed += f"  discarded {view.discarded}" if view.discarded else ""
    text = f" stream {rate}  {f'last state {age} ago' if has_state else 'no state yet'}{missed}"
    text += f"  connection lost {drops}x" if drops else ""
    if len(text) > width:
        text = f" {rate}  {f'{age} ago' if has_state else 'no state'}{missed}"
        text = fit(text + (f"  lost {drops}x" if drops else ""), width)
    return Text(text, style="bold red" if view.age > 0.25 else "")


def fit(text: str, width: int) -> str:
    """Return a text, cut where it is longer than a line."""
    return text if len(text) <= width else text[: max(0, width - 1)] + "…"
