"""Where the rest of the error sits: the flaw's pattern is named, and nothing of a sound arm."""

import math

import pytest
from rest_patterns import EXPECTED, draw

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("kind", "size", "seed"), [("encoder", 4e-4, 1), ("sag", 2.5e-3, 1), ("warm", 4e-4, 0)]
)
def test_the_pattern_of_a_flaw_is_named(kind, size, seed):
    joint, patterns = draw(kind, size, seed)
    assert patterns.strongest in EXPECTED.get(kind, (joint,))
    by_name = {pattern.over: pattern for pattern in patterns.patterns}
    strongest = by_name[patterns.strongest]
    assert strongest.log_odds == max(p.log_odds for p in by_name.values()) > math.log(20)
    beyond = [abs(m) > b for m, b in zip(strongest.mean, strongest.band, strict=True)]
    assert kind == "sag" or any(beyond)


def test_no_pattern_of_a_sound_arm_is_named():
    _, patterns = draw("none", 0.0, 0)
    assert patterns.strongest is None and "no pattern" in patterns.text
