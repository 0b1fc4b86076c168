"""A cause that was accepted as a diagnostic: its words, its place, and how much it matters."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from ..identification.data import Measurement
from ..results import Consequence, Diagnostic, Hypothesis
from .configurations import row_of, where_of
from .consequence import consequence_of, level_of, nominal_errors
from .corrections import PLAY_HINT
from .hypotheses import Candidate
from .ranking import HIDDEN
from .scene_fit import MENDER, Given

SEATED = 0.03
"""Distance from its socket [m] beyond which a ball was elsewhere, not just badly seated."""
LEAST_GAIN = 2e-3
"""Gears have some hundred teeth: a wrong ratio is off by more than this share, an uneven joint
may look like less."""
SMALLEST_MOVE = 7.5e-4
"""A base that is knocked moves by more than this [m]; less may be how the arm was guided."""
FITTED = ("length", "angle", "version", "zero")
"""Causes whose numbers are unknowns of the fit: how well it has them, the errors say, unless the
samples scatter like those of gears with play, which hides zeros."""
LEAST_SAG = 5e-3
"""Less sags an arm of gears, which the fit knows as elasticity [rad]."""
MOST_DRIFT = 3e-3
"""Drifts over a placement below this are no error [m], since the fit holds them."""
PLAY = 0.015
"""The same where gears have play, which looks like a drift [m]."""
MOST_NOISE = 5e-3
"""Unexplained noise below this, and less than half of the nominal errors, is no error [m]."""
GARBAGE = 1e-2
"""A placement that leaves more than this when fitted alone is no recording of a ball in a socket
[m]."""
OUT_OF_REACH = 0.1
"""Where each placement leaves more, no fit gets from the nominal model to the arm [m]."""
LOOSE = 5e-4
"""Noise from which gears with play are suggested as the cause [m]."""
HELD_OUT = (
    "; only the test used this placement: the model is unharmed, "
    "and its true error here is smaller"
)
"""Added to the advice on what is weighed by the model in a placement to train on."""
APART = "; give what was recorded before it, and after it, as placements of their own"
"""Added where a fit that has an unknown for it is far off nevertheless."""
UNKNOWNS = ("base_moved", "base_tipped", "drift", "zero_lost", "ball_bent")
"""Differences between places, for which the fit has unknowns."""
ELSEWHERE = "it was recorded elsewhere, by another base or arm; solve leaves it out"
POINT_ELSEWHERE = "it is of another target, or of another pose; solve leaves it out"


@dataclass(frozen=True)
class Finding:
    """A cause in the recordings of an inspection."""

    cause: Candidate
    measurements: Sequence[Measurement]
    given: Given
    zeros: bool
    """The joints may have offsets of degrees."""

    @cached_property
    def hypothesis(self) -> Hypothesis:
        """The cause in words."""
        return self.cause.hypothesis()

    @property
    def placement(self) -> str | None:
        """Name of the placement that has it; None for all."""
        return self.cause.parameters.get("placement")

    @property
    def is_held_out(self) -> bool:
        """True where no placement to train on has it."""
        trained = self.given.trained
        names = (
            [self.placement] if self.placement else [m.name for m in self.measurements]
        )
        return bool(trained) and set(trained).isdisjoint(names)

    @property
    def is_scattered(self) -> bool:
        """True where samples scatter so much that nothing can be trusted, however fitted."""
        return self.cause.parameters.get("noise_here", 0.0) >= MOST_NOISE

    @property
    def is_unknown(self) -> bool:
        """True where the fit has an unknown for it."""
        is_fitted = self.given.weighs and not self.is_held_out
        return is_fitted and self.hypothesis.name in UNKNOWNS

    @cached_property
    def consequence(self) -> Consequence | None:
        """Its effect on a model; None where no fit tells, or it is held out."""
        if self.is_held_out or not self.cause.kind.weighed:
            return None
        return consequence_of(self.cause, self.given.trained)

    @cached_property
    def diagnostic(self) -> Diagnostic:
        """It in words, and how much it matters."""
        cause, hypothesis = self.cause, self.hypothesis
        code, advice = cause.kind.code, hypothesis.advice
        level = self._level()
        if hypothesis.name == "ball_sample" and self._is_elsewhere():
            code = "elsewhere"
            advice = POINT_ELSEWHERE if cause.of_points else ELSEWHERE
        advice = by_mender(advice, self.given)
        is_error = level == "error"
        may_be_play = cause.kind.of_play and cause.parameters["noise"] > LOOSE
        if is_error and may_be_play and not self.zeros:
            advice += PLAY_HINT
        if self.is_held_out and hypothesis.name == "copies":
            level = "note"  # it proves nothing, as the errors held out say
        sound_enough = not (self.is_scattered or self._is_garbage())
        if self.is_held_out and (cause.kind.weighed or is_error) and sound_enough:
            level = "warning"
            advice = without_unknown(advice, self.given.mender) + HELD_OUT
        elif self.is_unknown and is_error and sound_enough:
            level = "warning"
        elif self.is_unknown and is_error and hypothesis.name != "drift":
            advice = by_mender(hypothesis.advice, self.given)
            advice = without_unknown(advice, self.given.mender) + APART
        return Diagnostic(
            level, code, self._where(), hypothesis.text, advice, self.consequence
        )

    def _is_elsewhere(self) -> bool:
        """Tell whether a sample is left out: it is far off, or hides others that are."""
        parameters = self.cause.parameters
        seated = GARBAGE if self.cause.of_points else SEATED
        return parameters["size"] > seated or HIDDEN in parameters

    def _level(self) -> str:
        """Return how much it matters, by its consequence where there is one."""
        level = self.cause.kind.level
        if self.consequence is not None and not self.is_scattered:
            level = level_of(self.consequence, self.cause.scene.noise)
        if level == "error" and (self._is_slight() or self._is_noise()):
            return "warning"
        return level

    def _where(self) -> str:
        """Return the sample, the placement or the known distance that it concerns."""
        p = self.cause.parameters
        if "known" in p:
            return f"--known {p['known']}"
        if self.cause.of_all:
            return where_of(self.measurements)
        measured = next(m for m in self.measurements if m.name == self.placement)
        if "sample" in p and not p.get("throughout"):
            return row_of(measured, p["socket"], p["sample"])
        return where_of([measured])

    def _is_slight(self) -> bool:
        """Tell whether something else says how much it matters, or it is a small one.

        Of a distance, the size of the arm decides; of what is fitted, the errors.
        """
        name, p = self.cause.kind.name, self.cause.parameters
        if name == "gain":
            return abs(p["offset"]) < LEAST_GAIN
        if name in FITTED:
            floors = self.cause.scene.floors
            return p["noise"] <= LOOSE and min(floors, default=0.0) <= OUT_OF_REACH
        smallest = {
            "base_moved": SMALLEST_MOVE,
            "base_tipped": SMALLEST_MOVE,
            "commands": LEAST_SAG,
            "drift": PLAY if self.zeros else MOST_DRIFT,
        }
        return name == "distance" or p.get("size", 0.0) < smallest.get(name, 0.0)

    def _is_garbage(self) -> bool:
        """Tell whether its placement, fitted alone, leaves a centimetre, held out or not."""
        scene = self.cause.scene
        # none beside a cause of all
        floors = zip(scene.measurements, scene.floors, strict=False)
        return any(m.name == self.placement and floor > GARBAGE for m, floor in floors)

    def _is_noise(self) -> bool:
        """Tell whether it is noise that a fit averages out, and far from the nominal errors."""
        kind, sigma = self.cause.kind, self.cause.sigma
        if kind.noise is None or sigma >= MOST_NOISE:
            return False
        if kind.name != "unexplained":
            return True
        return sigma < nominal_errors(self.cause.scene) / 2

    @property
    def explains_errors(self) -> bool:
        """True where it may be why placements fitted alone leave much."""
        diagnostic = self.diagnostic
        is_serious = diagnostic.level == "error" or diagnostic.advice.endswith(HELD_OUT)
        is_serious |= self.is_unknown
        of_frame = "frame" in self.cause.parameters
        kind = self.cause.kind
        is_noise = kind.noise is not None and kind.name != "unexplained"
        return is_serious or of_frame or is_noise or kind.name in FITTED


def without_unknown(
    advice: str,
    mender: str = MENDER,
) -> str:
    """Return advice on what no unknown of a fit holds."""
    return advice.replace(f"; {mender} corrects that, so keep these samples", "")


def by_mender(
    advice: str,
    given: Given,
) -> str:
    """Return advice by what sets recordings right: not every solve does."""
    return advice.replace(f"{MENDER} ", f"{given.mender} ", 1)
