"""A comparison of models in words: which is better where, beyond the noise and beyond chance."""

from ....solver.assessment import apart_words, joined, mm, plural
from ....solver.results import agreement_words
from .comparison_types import NOMINAL, ComparedPair, ComparisonDocument

SURPRISE = 0.05
"""Probability below which chance is no explanation."""
CHANGED, EXPLAINED = "something changed, or is not in the model", "chance explains that"


def comparison_title(result: ComparisonDocument) -> str:
    """Return the title of the errors by placement."""
    return "; ".join(["MAE in mm", *model_remarks(result), "* trained on"])


def model_remarks(result: ComparisonDocument) -> list[str]:
    """Return what the models are, where their names do not say it."""
    remarks: list[str] = []
    if result.ball_refitted:
        first = result.models[1].name
        remarks.append(f"{NOMINAL}: its ball refitted to what {first} was trained on")
    corrected = [model.name for model in result.models if model.corrected_joints]
    if corrected:
        remarks.append(f"{joined(corrected)}: with corrected joint positions")
    return remarks


def comparison_sentence(result: ComparisonDocument, pair: ComparedPair) -> str:
    """Return in words which of two models is better, where, and by how much beyond the noise."""
    words = [
        _errors_sentence(result, pair),
        _chance_sentence(pair),
        agreement_words(pair.curves),
    ]
    return " ".join(filter(None, words))


def _chance_sentence(pair: ComparedPair) -> str:
    """Return how far two calibrations are apart, and whether chance alone explains it."""
    if pair.workspace is None:
        return ""
    everything = [
        pair.workspace,
        *(chance for chance in pair.by_chance if chance is not None),
    ]
    odds = len(everything) * min(chance.probability for chance in everything)
    beyond = sum(chance.beyond_chance for chance in everything[1:])
    text = f"beyond chance at {beyond} of {plural(len(everything) - 1, 'placement')}"
    reason = CHANGED if odds < SURPRISE else EXPLAINED
    return f"Apart in mm: {apart_words(pair.workspace)} in the workspace; {text}: {reason}."


def _errors_sentence(result: ComparisonDocument, pair: ComparedPair) -> str:
    a = result.models[pair.a].name
    b = result.models[pair.b].name
    summary = pair.summary
    if summary is None:
        return f"{b} against {a}: every placement was trained on by one of the models, so no word."
    count = plural(len(result.fair), "placement")
    where = f"over {count} that none was trained on"
    half_width = f"\N{PLUS-MINUS SIGN}{mm(summary.noise, 3)}, 95 %"
    rows = [pair.placements[i] for i in result.fair]
    better, worse = (b, a) if summary.mean < 0 else (a, b)
    wins = sum(row.beyond_noise and row.mean * summary.mean > 0 for row in rows)
    gap = mm(abs(summary.mean), 3)
    lead = f"{better} is better than {worse} by {gap} {where}, beyond the noise"
    if summary.beyond_noise:
        return f"{lead} (noise {half_width}) on the whole and at {wins} of them."
    if wins == len(rows):
        return (
            f"{lead} at each of them; they are too few, or too unlike, to say so of other places "
            f"({half_width})."
        )
    either = f"{b} and {a} differ by {gap} {where}, which is within"
    if any(row.beyond_noise for row in rows):
        return f"{either} the spread between placements ({half_width})."
    return f"{either} the noise (noise {half_width})."
