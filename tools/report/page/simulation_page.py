"""The report of a simulated experiment, with two models side by side."""

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path

from ....solver.assessment import joined, mm, nice_above
from ....solver.results import encode
from ...experiments import Drawing, Insertions, ModelTrials, SimulationDocument
from ..plots import Axis, Panel, Plot
from .html import Cell, Element, Node, figure, table, tag
from .html.frame import frame

TITLES = {"insertion": "Peg insertion, simulated", "drawing": "Drawing, simulated"}
WHERE = {"centre": "where it was taught", "cross": "on the X", "drawing": "drawing"}
PEG = 0.01
"""Its diameter [m]."""
PAPER = 0.5
"""Where the drawing's middle is along x [m]."""
COLOURS = 6
"""Lines that the style sheet has colours for."""
CAPTIONS = {
    "picture.png": "The trial whose elbow started farthest from where the goal was taught, in the "
    "end. {below}",
    "animation.gif": "The same trial from its start, at twice its speed.",
}
BELOW = {
    "insertion": "Below, the block is cut open at the hole.",
    "drawing": "Below, the paper with the lines of all trials; what was shown is grey.",
}

OFF = {
    "insertion": "Off: the peg's true distance from its place above the hole, when it is about to "
    "go down; mean, and the most in brackets. Forces are from then on; the least and the most of "
    "the trials in brackets.",
    "drawing": "Apart: the largest distance between any two lines at each moment. Off: a line's "
    "mean distance from what was shown. Mean, and the most in brackets; of forces, the least and "
    "the most of the trials.",
}


def simulation_page(result: SimulationDocument, pictures: Mapping[str, bytes]) -> str:
    """Return the report as HTML that needs no other file.

    Args:
        result: What came of the experiment with both models.
        pictures: The files' contents by name; none where they could not be made.
    """
    experiment = result.experiment
    shown = [
        _picture(name, pictures[name], words.format(below=BELOW[experiment]))
        for name, words in CAPTIONS.items()
        if name in pictures
    ]
    body = [
        tag(
            "header",
            tag("p", f"Simulated arm {result.arm}, seed {result.seed}", class_="kicker"),
            tag("h1", TITLES[experiment]),
        ),
        tag(
            "section",
            tag("h2", "What came of it"),
            tag("p", _sentence(result)),
            _table(result),
            tag("p", OFF[experiment], class_="help"),
        ),
        tag("section", tag("h2", "Side by side"), shown, class_="plots") if shown else None,
        tag(
            "section",
            tag("h2", "Trial by trial"),
            (_lines if experiment == "drawing" else _misses)(result).element(),
            class_="plots",
        ),
    ]
    return frame(TITLES[experiment], body, {"figures": encode(result, compact=True)})


def _models(result: SimulationDocument) -> list[tuple[str, ModelTrials]]:
    """Return where each model's figures stand in the result, and the figures."""
    beside = [] if result.beside is None else [("beside.", result.beside)]
    return [*beside, ("", result)]


def _insertions(model: ModelTrials) -> list[tuple[str, Insertions]]:
    """Return the places where pegs were inserted, and what came of it."""
    places = (("centre", model.centre), ("cross", model.cross))
    return [(place, trials) for place, trials in places if trials is not None]


def _sentence(result: SimulationDocument) -> str:
    """Return the result in words, the model beside first."""
    parts = [
        _apart(model, model.drawing) if model.drawing else _inserted(model)
        for _, model in _models(result)
    ]
    where = f"Into a hole of {1e3 * result.hole:g} mm: " if result.hole else ""
    text = f"{where}{'; '.join(parts)}. Gains, friction and starts are the same for both."
    return text[0].upper() + text[1:]


def _apart(model: ModelTrials, lines: Drawing) -> str:
    return (
        f"the {_name(model)} model's {lines.retracings} lines lie {mm(lines.spread)} apart on "
        f"average and {mm(lines.max_spread)} at most"
    )


def _inserted(model: ModelTrials) -> str:
    counts = [
        f"{trials.inserted} of {trials.trials} {WHERE[place]}"
        for place, trials in _insertions(model)
    ]
    return f"with the {_name(model)} model {joined(counts)}"


def _name(model: ModelTrials) -> str:
    return Path(model.model).name


def _table(result: SimulationDocument) -> Element:
    drawing = result.drawing is not None
    places = ["drawing"] if drawing else [place for place, _ in _insertions(result)]
    rows = [
        [_name(model), WHERE[place], *_cells(result, f"{at}{place}.", drawing=drawing)]
        for place in places
        for at, model in _models(result)
    ]
    first = "lines apart, mm (most)" if drawing else "inserted"
    heads = ["model", "", first, "off, mm (most)", "force, N (each trial's mean)", "peak force, N"]
    return table(heads, rows)


def _cells(result: SimulationDocument, path: str, *, drawing: bool) -> list[Cell]:
    """Return the cells of one model at one place."""

    def newtons(key: str) -> Sequence[Node]:
        mean, low, high = (
            figure(result, f"{path}{key}.{word}", scale=1, digits=1)
            for word in ("mean", "min", "max")
        )
        return [mean, " (", low, " to ", high, ")"]

    def lengths(key: str) -> Sequence[Node]:
        most = figure(result, f"{path}max_{key}", digits=2)
        return [figure(result, f"{path}{key}", digits=2), " (", most, ")"]

    if drawing:
        first = lengths("spread")
    else:
        inserted, trials = (
            figure(result, f"{path}{key}", scale=1, digits=0) for key in ("inserted", "trials")
        )
        first = [inserted, " of ", trials]
    return [first, lengths("tracking_error"), newtons("force"), newtons("peak_force")]


def _picture(name: str, content: bytes, caption: str) -> Element:
    kind = name.rsplit(".", 1)[1]
    data = base64.b64encode(content).decode()
    return tag(
        "figure",
        tag("img", src=f"data:image/{kind};base64,{data}", alt=caption, style="max-width: 100%"),
        tag("figcaption", caption),
        id=name.split(".")[0],
        class_="plot half",
    )


def _misses(result: SimulationDocument) -> Plot:
    """Return where the peg was just before it went down, by the true kinematics."""
    panels: list[Element] = []
    for k, (_, model) in enumerate(_models(result)):
        each = [one for _, trials in _insertions(model) for one in trials.each]
        play = 1e3 * ((result.hole or PEG) - PEG) / 2
        reach = max(play, *(1e3 * abs(x) for one in each for x in one.miss[:2]))
        panel = _square(_name(model), nice_above(1.05 * reach), "mm along x", "mm along y")
        panel.add(
            "circle",
            cx=panel.x(0),
            cy=panel.y(0),
            r=abs(panel.x(play) - panel.x(0)),
            class_="threshold",
        )
        for one in each:
            x, y = (1e3 * value for value in one.miss[:2])
            hint = f"{x:+.2f}, {y:+.2f} mm; {'in' if one.inserted else 'not in'}"
            panel.dot(x, y, f"model-{k}" + ("" if one.inserted else " train"), hint, 4)
        panels.append(panel.root)
    return Plot(
        "misses",
        "Where the peg went down",
        "The peg's true place above the hole's axis, just before it goes down. Inside the dashed "
        "circle it does not touch the rim; a rounded edge and the spring find a little more.",
        tuple(panels),
        (("hollow", "hollow: not inserted"),),
    )


def _lines(result: SimulationDocument) -> Plot:
    """Return the lines that were drawn."""
    panels: list[Element] = []
    for _, model in _models(result):
        panel = _square(_name(model), 100, "mm to the right", "mm ahead")
        for i, one in enumerate(model.drawing.each if model.drawing else ()):
            line = [(-1e3 * y, 1e3 * (x - PAPER)) for x, y in one.line]
            panel.line(line, f"curve model-{i % COLOURS}")
        panels.append(panel.root)
    return Plot(
        "lines",
        "What was drawn",
        "The pen's true path over the paper, one colour a trial, whether or not it pressed on it.",
        tuple(panels),
    )


def _square(title: str, half: float, x: str, y: str) -> Panel:
    """Return a panel from -half to half both ways, to the same scale."""
    return Panel(title, Axis(-half, half, x), Axis(-half, half, y), height=460).grid()
