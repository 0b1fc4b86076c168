"""Prior on an arm's elasticity, much the same in a type, from calibrations of other arms."""

from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files as resources
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from .. import results
from ..bayes.model import Expected
from ..bayes.model.effects import EFFECTS
from ..robot import Robot
from .option import UsageError

_SHIPPED = Path(str(resources("mukca.solver.robot") / "shipped" / "elasticity.json"))
SHIPPED = "shipped"
SHARED = [effect for effect in EFFECTS.values() if effect.shared_by_type]
TypePriors = Sequence[Mapping[str, Expected]]
"""Of each robot: by extension, expected coefficients and their deviations."""
LEAST = 1e-9
"""No deviation is less [rad/(N m)], so that it can be divided by."""


def type_priors(files: Sequence[str | Path], robots: Sequence[Robot]) -> list[dict[str, Expected]]:
    """Return what is known of the elasticity of each robot's type, by extension."""
    own = [robot.joint_names for robot in robots]
    told: list[results.TypeElasticity] = []
    for file in [files] if isinstance(files, str) else files:
        if file != "none":
            types = _types(_SHIPPED if file == SHIPPED else Path(file))
            told += types if file == SHIPPED else _useful(file, types, own)
    pooled = {one.joint_names: one for one in _pooled(told)}
    return [_expected(pooled.get(joints)) for joints in own]


def _useful(
    file: str | Path, types: Sequence[results.TypeElasticity], own: Sequence[tuple[str, ...]]
) -> Sequence[results.TypeElasticity]:
    """Return what a file tells; refuse one that tells nothing of these robots."""
    joints = [one.joint_names for one in types]
    if not set(own) & set(joints):
        known, others = ("; ".join(map(", ".join, each)) for each in (dict.fromkeys(own), joints))
        raise UsageError(
            f"--type-prior {file}: of an arm with the joints {others}, while this has {known}"
        )
    if not any(one.coefficients for one in types):
        raise UsageError(
            f"--type-prior {file}: no elasticity was found in that arm; give calibrations "
            "that list `compliance` or `tilt` under `deflection`"
        )
    return types


def learn_types(files: Iterable[Path]) -> results.ElasticityDocument:
    """Return the elasticity of each type of arm that some ``calibration.json`` are of."""
    types = _pooled([one for file in files for one in _types(file) if one.coefficients])
    return results.ElasticityDocument(format=results.ELASTICITY_FORMAT, types=tuple(types))


def _types(file: Path) -> tuple[results.TypeElasticity, ...]:
    if results.format_of(file) == results.ELASTICITY_FORMAT:
        return results.read(file, results.ElasticityDocument, results.ELASTICITY_FORMAT).types
    try:
        document = results.read_calibration(file)
    except results.DocumentError as error:
        either = str(error).replace("a calibration.json", "a calibration.json or elasticity.json")
        raise results.DocumentError(either) from None
    joints = document.model.joint_names
    kept = [effect for effect in SHARED if effect.name in document.deflection]
    names = {name for effect in kept for name in effect.coefficient_names(joints)}
    found = tuple(one for one in document.coefficients or () if one.name in names)
    return (results.TypeElasticity(joint_names=joints, arms=1, coefficients=found),)


def _pooled(types: Sequence[results.TypeElasticity]) -> list[results.TypeElasticity]:
    """Return one for each type: the means of its coefficients."""
    pooled: list[results.TypeElasticity] = []
    for joints in dict.fromkeys(one.joint_names for one in types):
        own = [one for one in types if one.joint_names == joints]
        by_name: dict[str, list[results.Coefficient]] = {}
        for coefficient in (c for one in own for c in one.coefficients):
            by_name.setdefault(coefficient.name, []).append(coefficient)
        means = tuple(map(_mean, by_name.values()))
        arms = sum(one.arms for one in own)
        pooled.append(results.TypeElasticity(joint_names=joints, arms=arms, coefficients=means))
    return pooled


def _mean(each: Sequence[results.Coefficient]) -> results.Coefficient:
    weights = np.array([max(one.standard_deviation, LEAST) for one in each]) ** -2
    mean = float(weights @ [one.value for one in each] / weights.sum())
    return replace(each[0], value=mean, standard_deviation=float(weights.sum() ** -0.5))


def _expected(known: results.TypeElasticity | None) -> dict[str, Expected]:
    """Return what is known of a type, by extension."""
    if known is None:
        return {}
    by_name = {one.name: (one.value, one.standard_deviation) for one in known.coefficients}
    expected: dict[str, Expected] = {}
    for effect in SHARED:
        names = effect.coefficient_names(known.joint_names)
        if all(name in by_name for name in names):
            values, deviations = np.array([by_name[name] for name in names]).T
            expected[effect.name] = values, deviations
    return expected
