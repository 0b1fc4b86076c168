"""Priors of an arm's elasticity by calibrations of others of its type (``--type-prior``)."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from importlib.resources import files as resources
from itertools import chain
from pathlib import Path

import numpy as np
from msgspec import structs

from .. import results
from ..bayes.model import Expected
from ..bayes.model.effects import EFFECTS, Effect
from ..robot import Robot
from .option import UsageError

_SHIPPED = Path(str(resources("mukca.solver.robot") / "shipped" / "elasticity.json"))
SHIPPED = "shipped"
TypePriors = Sequence[Mapping[str, Expected]]
"""Of each robot: by extension, expected coefficients and their deviations."""
LEAST = 1e-9
"""No deviation is less [rad/(N m)], so that it can be divided by."""


def shared_effects() -> list[Effect]:
    """Effects that arms of one type have much the same."""
    return [effect for effect in EFFECTS.values() if effect.shared_by_type]


def type_priors(files: Sequence[str | Path], robots: Sequence[Robot]) -> list[dict[str, Expected]]:
    """Return the expected elasticity of each robot's type, by extension."""
    joint_names = [robot.joint_names for robot in robots]
    types = list(
        chain.from_iterable(_types_for(file, joint_names) for file in files if file != "none")
    )
    other_tilts = {robot.joint_names: tilts_about_other_axes(robot) for robot in robots}
    types = [
        _without_tilts(elasticity, other_tilts.get(elasticity.joint_names, ()))
        for elasticity in types
    ]
    pooled = {elasticity.joint_names: elasticity for elasticity in _pooled(types)}
    return [_expected(pooled.get(joints)) for joints in joint_names]


def tilts_about_other_axes(robot: Robot) -> list[str]:
    """Return the tilts of a robot that files of 1.0 hold about other axes than today's."""
    if all(joint.tilts_by_frame for joint in robot.actuated):
        return []
    effects = [effect for effect in shared_effects() if effect.across]
    return list(chain(*(effect.coefficient_names(robot.joint_names) for effect in effects)))


def _without_tilts(
    elasticity: results.TypeElasticity, names: Collection[str]
) -> results.TypeElasticity:
    """Return a type without some tilts, if they are about the axes of frames."""
    if elasticity.tilt_axes == "link":
        return elasticity
    coefficients = tuple(
        coefficient for coefficient in elasticity.coefficients if coefficient.name not in names
    )
    return structs.replace(elasticity, coefficients=coefficients)


def _types_for(
    file: str | Path, names_of_arms: Sequence[tuple[str, ...]]
) -> Sequence[results.TypeElasticity]:
    """Return the types in a file; refuse one of the user's that has none of these robots."""
    if file == SHIPPED:
        return _types(_SHIPPED)
    types = _types(Path(file))
    joints = [elasticity.joint_names for elasticity in types]
    if not set(names_of_arms) & set(joints):
        ours = "; ".join(map(", ".join, dict.fromkeys(names_of_arms)))
        theirs = "; ".join(map(", ".join, joints))
        raise UsageError(
            f"--type-prior {file}: of an arm with the joints {theirs}, while this has {ours}"
        )
    if not any(elasticity.coefficients for elasticity in types):
        names = " or ".join(f"`{effect.name}`" for effect in shared_effects())
        raise UsageError(
            f"--type-prior {file}: no elasticity was found in that arm; give calibrations "
            f"that list {names} under `deflection`"
        )
    return types


def learn_types(files: Iterable[Path]) -> results.ElasticityDocument:
    """Return the elasticity of each type of arm that some ``calibration.json`` are of."""
    types = [t for t in chain.from_iterable(map(_types, files)) if t.coefficients]
    by_frame = _pooled([elasticity for elasticity in types if elasticity.tilt_axes == "frame"])
    by_link = _pooled([elasticity for elasticity in types if elasticity.tilt_axes == "link"])
    return results.ElasticityDocument(format=results.ELASTICITY_FORMAT, types=(*by_frame, *by_link))


def _types(file: Path) -> tuple[results.TypeElasticity, ...]:
    if results.format_of(file) == results.ELASTICITY_FORMAT:
        return results.read(file, results.ElasticityDocument, results.ELASTICITY_FORMAT).types
    try:
        document = results.read_calibration(file)
    except results.DocumentError as error:
        either = str(error).replace("a calibration.json", "a calibration.json or elasticity.json")
        raise results.DocumentError(either) from None
    joints = document.model.joint_names
    effects = [effect for effect in shared_effects() if effect.name in document.deflection]
    names = set(chain.from_iterable(effect.coefficient_names(joints) for effect in effects))
    coefficients = tuple(
        coefficient for coefficient in document.coefficients or () if coefficient.name in names
    )
    axes = "frame" if document.rotation_numbers == "rpy" else "link"
    elasticity = results.TypeElasticity(
        joint_names=joints, arms=1, coefficients=coefficients, tilt_axes=axes
    )
    return (elasticity,)


def _pooled(types: Sequence[results.TypeElasticity]) -> list[results.TypeElasticity]:
    """Return one for each type: the means of its coefficients."""
    pooled: list[results.TypeElasticity] = []
    for joints in dict.fromkeys(elasticity.joint_names for elasticity in types):
        of_arm = [elasticity for elasticity in types if elasticity.joint_names == joints]
        coefficients = list(chain.from_iterable(elasticity.coefficients for elasticity in of_arm))
        names = dict.fromkeys(coefficient.name for coefficient in coefficients)
        by_name = {name: list[results.Coefficient]() for name in names}
        for coefficient in coefficients:
            by_name[coefficient.name].append(coefficient)
        means = tuple(map(_mean, by_name.values()))
        arms = sum(elasticity.arms for elasticity in of_arm)
        pooled.append(structs.replace(of_arm[0], arms=arms, coefficients=means, source=None))
    return pooled


def _mean(coefficients: Sequence[results.Coefficient]) -> results.Coefficient:
    weights = (
        np.array([max(coefficient.standard_deviation, LEAST) for coefficient in coefficients]) ** -2
    )
    mean = float(weights @ [coefficient.value for coefficient in coefficients] / weights.sum())
    return structs.replace(
        coefficients[0], value=mean, standard_deviation=float(weights.sum() ** -0.5)
    )


def _expected(elasticity: results.TypeElasticity | None) -> dict[str, Expected]:
    """Return the expected coefficients of a type and their deviations, by extension."""
    if elasticity is None:
        return {}
    by_name = {
        coefficient.name: (coefficient.value, coefficient.standard_deviation)
        for coefficient in elasticity.coefficients
    }
    expected: dict[str, Expected] = {}
    for effect in shared_effects():
        names = effect.coefficient_names(elasticity.joint_names)
        if all(name in by_name for name in names):
            values, deviations = np.array([by_name[name] for name in names]).T
            expected[effect.name] = values, deviations
    return expected
