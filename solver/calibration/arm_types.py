"""Priors of an arm's elasticity by calibrations of others of its type (``--type-prior``)."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from importlib.resources import files as resources
from itertools import chain
from pathlib import Path

import numpy as np
from msgspec import structs

from .. import results
from ..identification.effects import EFFECTS, Effect
from ..identification.model import Expected
from ..identification.robot import Robot
from .option import UsageError

_SHIPPED = Path(
    str(resources("mukca.solver.identification.robot") / "shipped" / "elasticity.json")
)
SHIPPED = "shipped"
LEAST = 1e-9
"""No deviation is less [rad/(N m)], so that it can be divided by."""


def shared_effects() -> list[Effect]:
    """Effects that arms of one type have much the same."""
    return [effect for effect in EFFECTS.values() if effect.shared_by_type]


def type_priors(
    files: Sequence[str | Path], robots: Sequence[Robot]
) -> list[dict[str, Expected]]:
    """Return the expected elasticity of each robot's type, by extension."""
    joint_names = [robot.joint_names for robot in robots]
    types = list[results.TypeElasticity]()
    for file in files:
        types += _types_for(file, joint_names) if file != "none" else ()
    return [_expected(robot, types) for robot in robots]


def tilts_about_other_axes(robot: Robot) -> list[str]:
    """Return the tilts of a robot that files of 1.0 hold about other axes than today's."""
    if all(joint.tilts_by_frame for joint in robot.actuated):
        return []
    effects = [effect for effect in shared_effects() if effect.across]
    return list(
        chain(*(effect.coefficient_names(robot.joint_names) for effect in effects))
    )


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
    groups = defaultdict[tuple[str, tuple[str, ...]], list[results.TypeElasticity]](
        list
    )
    for elasticity in sorted(types, key=lambda elasticity: elasticity.tilt_axes):
        groups[elasticity.tilt_axes, elasticity.joint_names].append(elasticity)
    pooled = tuple(map(_pooled, groups.values()))
    return results.ElasticityDocument(format=results.ELASTICITY_FORMAT, types=pooled)


def _types(file: Path) -> tuple[results.TypeElasticity, ...]:
    if results.format_of(file) == results.ELASTICITY_FORMAT:
        return results.read(
            file, results.ElasticityDocument, results.ELASTICITY_FORMAT
        ).types
    try:
        document = results.read_calibration(file)
    except results.DocumentError as error:
        either = str(error).replace(
            "a calibration.json", "a calibration.json or elasticity.json"
        )
        raise results.DocumentError(either) from None
    joints = document.model.joint_names
    effects = [
        effect for effect in shared_effects() if effect.name in document.deflection
    ]
    names = set(
        chain.from_iterable(effect.coefficient_names(joints) for effect in effects)
    )
    elasticity = results.TypeElasticity(
        joint_names=joints,
        arms=1,
        coefficients=tuple(c for c in document.coefficients or () if c.name in names),
        tilt_axes="frame" if document.rotation_numbers == "rpy" else "link",
    )
    return (elasticity,)


def _pooled(types: Sequence[results.TypeElasticity]) -> results.TypeElasticity:
    """Return the elasticity of all arms of a type."""
    means = _means(chain.from_iterable(elasticity.coefficients for elasticity in types))
    arms = sum(elasticity.arms for elasticity in types)
    return structs.replace(types[0], arms=arms, coefficients=means, source=None)


def _means(
    coefficients: Iterable[results.Coefficient],
) -> tuple[results.Coefficient, ...]:
    """Return coefficients of one name as their mean, each weighted by its precision."""
    by_name = defaultdict[str, list[results.Coefficient]](list)
    for coefficient in coefficients:
        by_name[coefficient.name].append(coefficient)
    means = list[results.Coefficient]()
    for same in by_name.values():
        deviations = np.array([coefficient.standard_deviation for coefficient in same])
        weights = np.maximum(deviations, LEAST) ** -2
        mean = float(
            weights @ [coefficient.value for coefficient in same] / weights.sum()
        )
        deviation = float(weights.sum() ** -0.5)
        means.append(structs.replace(same[0], value=mean, standard_deviation=deviation))
    return tuple(means)


def _expected(
    robot: Robot, types: Sequence[results.TypeElasticity]
) -> dict[str, Expected]:
    """Return the expected coefficients of a robot's type and their deviations, by extension."""
    other_tilts = tilts_about_other_axes(robot)
    coefficients = list[results.Coefficient]()
    for elasticity in types:
        if elasticity.joint_names == robot.joint_names:
            names = other_tilts if elasticity.tilt_axes == "frame" else ()
            coefficients += [c for c in elasticity.coefficients if c.name not in names]
    by_name = {c.name: (c.value, c.standard_deviation) for c in _means(coefficients)}
    expected: dict[str, Expected] = {}
    for effect in shared_effects():
        names = effect.coefficient_names(robot.joint_names)
        if by_name.keys() >= set(names):
            values, deviations = np.array([by_name[name] for name in names]).T
            expected[effect.name] = Expected(values, deviations)
    return expected
