"""The two views that turn under the mouse; the page's script draws them from the figures."""

from ....solver.assessment import ModelName, mm, nice_above, plural
from ..figures import ReportDocument
from ..page.html import Element, tag
from .plot import BOTH, Plot, lengths
from .samples import FINE

_HELP = "Drag to turn (arrow keys too), pinch or Ctrl and wheel to enlarge, double-click to reset."


def _canvas(scene: str, model: str, words: str) -> Element:
    return tag(
        "div",
        tag("p", words, class_="over"),
        tag(
            "canvas",
            data_scene=scene,
            data_model=model,
            tabindex=0,
            role="img",
            aria_label=f"{words}; turns by dragging",
        ),
        class_="scene",
    )


def errors_in_3d(report: ReportDocument) -> Plot:
    """Every sample round its socket, nominal and calibrated side by side, to one scale."""
    nominal, calibrated = _largest(report, "nominal"), _largest(report, "calibrated")
    limit = report.limits.mean_absolute_error.value
    ring = f"; the dashed ring is the limit of {mm(limit)} on the mean" if limit else ""
    half = nice_above(max(nominal, calibrated, 1e-6), FINE)
    sentence = (
        f"Both boxes are {2e3 * half:g} mm wide: the farthest of {len(report.samples)} samples "
        f"is {mm(nominal)} from its socket's centre by the nominal model and "
        f"{mm(calibrated)} by the calibrated one{ring}."
    )
    choices = [("all", "all placements"), ("test", "held out"), ("train", "trained on")]
    choices += [(str(i), row.name) for i, row in enumerate(report.placements)]
    controls = tag(
        "p",
        tag(
            "label",
            "Show ",
            tag("select", [tag("option", w, value=v) for v, w in choices], data_control="filter"),
        ),
        tag("span", _HELP, class_="help"),
        class_="controls",
    )
    panels = (
        _canvas("errors", "nominal", "nominal"),
        _canvas("errors", "calibrated", "calibrated, to the same scale"),
    )
    return Plot(
        "errors-3d",
        "The error of every sample, in space",
        sentence,
        (controls, *panels),
        (*BOTH, ("hollow", "hollow: trained on")),
        "scenes",
    )


def _largest(report: ReportDocument, model: ModelName) -> float:
    """Return the error of the farthest sample [m]."""
    return float(lengths(report, model).max(initial=0.0))


def arm_in_3d(report: ReportDocument) -> Plot:
    """The arm in its recorded configurations, nominal against calibrated."""
    arm = report.arm
    count = len(arm.placements)
    factor = arm.exaggeration
    shown = f"drawn {factor:g} times as large at first" if factor > 1 else "drawn as it is"
    sentence = (
        f"In {plural(count, 'recorded configuration')} the two models put the ball "
        f"{mm(arm.displacement.mean)} apart on average and {mm(arm.displacement.max)} "
        f"at most, {shown}."
    )
    factors = sorted({1.0, factor, 10 * factor})
    controls = tag(
        "p",
        tag(
            "label",
            "Configuration ",
            tag("input", type="range", min=0, max=count - 1, value=0, data_control="configuration"),
        ),
        tag(
            "label",
            "Difference ",
            tag(
                "select",
                [
                    tag(
                        "option",
                        f"{k:g} x" if k != 1 else "true",
                        value=k,
                        selected="selected" if k == factor else None,
                    )
                    for k in factors
                ],
                data_control="factor",
            ),
        ),
        tag(
            "label",
            tag("input", type="checkbox", checked="checked", data_control="overlay"),
            " all configurations",
        ),
        tag("span", _HELP, class_="help"),
        class_="controls",
    )
    return Plot(
        "arm-3d",
        "The arm as it stood",
        sentence,
        (controls, _canvas("arm", "both", "nominal and calibrated")),
        (*BOTH, ("socket-key", "sockets")),
        "scenes one",
    )
