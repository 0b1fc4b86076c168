"""Awkward recordings go through all verbs: what fits none is refused, and every width is one."""

import pytest
from worlds.verbs import unsound_deviations, walked
from worlds.zoo import SHARED, random_case, zoo

pytestmark = pytest.mark.slow

CHEAPEST = [kind[0] for kind in zoo()]
AFTERWARDS = (("paper",), ("validate", "report"), ("rezero",), ("export",))
"""Beside ``check`` and ``solve``, by turns from case to case."""


def test_the_zoo_has_sixty_cases_of_all_kinds_of_arms():
    cases = [case for kind in zoo() for case in kind]
    assert len({case.name for case in cases}) == len(cases) == 60


@pytest.mark.parametrize("number", range(len(CHEAPEST)), ids=lambda n: CHEAPEST[n].name)
def test_nothing_but_refusals_comes_out_and_deviations_are_positive(number, tmp_path):
    case = CHEAPEST[number]
    if case.missing:
        pytest.skip(f"no recordings of real arms at {SHARED}")
    verbs = ("check", "solve", *AFTERWARDS[number % len(AFTERWARDS)])
    assert walked(case.recorded(), tmp_path, verbs).faults == []


def test_a_seed_makes_the_same_case_again():
    seed = next(seed for seed in range(99) if not random_case(seed).missing)
    first, again = random_case(seed), random_case(seed)
    assert first == again
    assert first.recorded() == again.recorded()


def test_a_deviation_that_is_none_is_named():
    document = {"a": [{"deviation": 0.0}], "deviations": [float("nan"), 1.0], "mean": -1.0}
    lines = [*unsound_deviations(document)]
    assert lines == [".a.0.deviation is 0.0", ".deviations.0 is nan"]
