"""What other arms of a type tell: it helps where it is right, and costs nothing where it is not."""

import json
from pathlib import Path

import numpy as np
import pytest

from mukca import calibrate
from mukca.recorder.dataset import Placement
from mukca.solver.bayes.model import Deflection, Expected
from mukca.solver.calibration import Calibration, UsageError, fit_by_auto, type_priors
from mukca.solver.data import evaluate, measure
from mukca.solver.results import DocumentError
from mukca.solver.robot import Robot, choose_parameters, load_robot
from mukca.tools.cli import main
from mukca.tools.fleet import ArmFolder, FleetArm, FleetSession
from mukca.tools.simulation import Imperfection, reachable_bases, record

TRUE = {
    "compliance": np.array([1, 4, 2, 6, 5, 3, 1]) * 1e-5,
    "tilt": np.array([2.5, 2, 1.6, 1.5, 1, 1, 0, 1.5, 0.5, 2.1, 0.2, 1, 1, 0]) * 1e-5,
}
"""Of a Panda-like arm [rad/(N m)]."""


@pytest.fixture(scope="module")
def recorded(panda: Robot, true_panda: Robot) -> list[Placement]:
    generator = np.random.default_rng(1)
    how = Imperfection(noise=7e-5, deflection=Deflection(tuple(TRUE), tuple(TRUE.values())))
    bases = reachable_bases(true_panda, generator, 3)
    return [
        record(true_panda, base, generator, samples=samples, imperfection=how)
        for base, samples in zip(bases, (10, 20, 20), strict=True)
    ]


@pytest.mark.slow
def test_a_right_one_helps_with_few_samples_and_wrong_ones_do_no_harm(
    panda: Robot, recorded: list[Placement]
) -> None:
    train, *test = (measure(placement, panda) for placement in recorded)

    def error(of_type: dict[str, Expected]) -> float:
        found = fit_by_auto(panda, choose_parameters(panda), [train], of_type=of_type).calibrated
        found = [evaluate(found.ball(m.positions), m).mean_absolute_error for m in test]
        return float(np.mean(found))

    def expected(values: dict[str, np.ndarray]) -> dict[str, Expected]:
        return {name: (value, np.full(len(value), 3e-6)) for name, value in values.items()}

    alone = error({})
    assert error(expected(TRUE)) < 0.98 * alone
    assert error(expected({name: 5 * value for name, value in TRUE.items()})) < 1.02 * alone
    # ten samples hardly tell joints apart that carry much the same load
    assert error(expected({name: value[::-1] for name, value in TRUE.items()})) < 1.05 * alone


@pytest.fixture(scope="module")
def other(panda: Robot, recorded: list[Placement]) -> Calibration:
    return calibrate(panda, recorded[1])


@pytest.mark.slow
def test_it_is_read_from_calibrations_weighted_by_their_precision(
    panda: Robot, other: Calibration, tmp_path
) -> None:
    files = other.save(tmp_path / "one")
    document = json.loads((tmp_path / "one" / "calibration.json").read_text())
    for coefficient in document["coefficients"]:
        coefficient["value"] += 6e-5
        coefficient["standard_deviation"] *= 2
    (tmp_path / "two.json").write_text(json.dumps(document))
    (one,) = type_priors([files["calibration"]], [panda])
    (both,) = type_priors([files["calibration"], tmp_path / "two.json"], [panda])
    assert set(one) >= {"compliance"}
    for name, (mean, deviation) in one.items():
        assert mean == pytest.approx(other.document.deflection[name])
        assert both[name][0] == pytest.approx(mean + 1.2e-5)
        assert both[name][1] == pytest.approx(deviation * 0.8**0.5)


@pytest.mark.slow
def test_what_was_measured_of_a_shipped_robots_type_counts_unless_told_otherwise(
    panda: Robot, other: Calibration, tmp_path
) -> None:
    (shipped,) = type_priors(["shipped"], [panda])
    (unknown,) = type_priors(["shipped"], [load_robot("ur5e")])
    mean, deviation = shipped["tilt"]
    assert not unknown and mean.shape == deviation.shape == (14,)
    assert (mean >= 0).all() and (deviation > 0).all() and 1e-5 < mean.max() < 5e-5
    assert type_priors(["none"], [panda]) == type_priors("none", [panda]) == [{}]
    (own,) = type_priors([other.save(tmp_path / "one")["calibration"]], [panda])
    assert not np.array_equal(own["tilt"][0], mean)


@pytest.mark.slow
def test_it_brings_back_nothing_that_is_not_to_be_tried(
    panda: Robot, recorded: list[Placement]
) -> None:
    untilted = calibrate(panda, recorded[1], without=("tilt",)).calibrated.deflection
    assert untilted.extensions and "tilt" not in untilted.extensions


@pytest.mark.slow
def test_solve_says_how_much_it_counts(panda: Robot, recorded: list[Placement]) -> None:
    by_default, without = (
        calibrate(panda, recorded[1], type_prior=words) for words in ((), ("none",))
    )
    assert by_default.document.settings["type_prior"] == ["shipped"]
    assert any("type prior: counts by" in line for line in by_default.document.choices or ())
    assert not any("type prior" in line for line in without.document.choices or ())


@pytest.mark.slow
def test_a_fleet_writes_what_its_arms_tell(
    panda: Robot, other: Calibration, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The arms' own calibrations tell the same as the one file; a refused one tells nothing."""
    files = other.save(tmp_path / "one")
    document = json.loads(Path(files["calibration"]).read_text())
    document["coefficients"][0]["value"] += 6e-5
    (tmp_path / "two.json").write_text(json.dumps(document))
    rows = {"a": (files["calibration"], "pass"), "b": (str(tmp_path / "two.json"), "fail")}
    rows |= {"c": ("", "refused")}

    def calibrated(arm: ArmFolder) -> FleetArm:
        file, status = rows[arm.folder.name]
        session = FleetSession(
            name="", placements=1, samples=60, held_out=False, nominal=1, calibrated=1,
            distance_error=None, status=status, text="", outputs={"calibration": file},
        )  # fmt: skip
        return FleetArm(name=arm.folder.name, robot="panda", sessions=(session,))

    monkeypatch.setattr("mukca.tools.fleet.calibrate.calibrate_arm", calibrated)
    for name in rows:
        (tmp_path / "arms" / name / "front").mkdir(parents=True)
        (tmp_path / "arms" / name / "front" / "hole_0.csv").touch()
    words = ["fleet", str(tmp_path / "arms"), "--robot", "panda", "--processes", "1"]
    main([*words, "--out", str(tmp_path / "out")])
    (pooled,) = type_priors([tmp_path / "out" / "elasticity.json"], [panda])
    (each,) = type_priors([file for file, _ in rows.values() if file], [panda])
    assert set(pooled) == set(each)
    for name in pooled:
        assert np.array(pooled[name]) == pytest.approx(np.array(each[name]))
    (entry,) = json.loads((tmp_path / "out" / "elasticity.json").read_text())["types"]
    assert entry["arms"] == 2


@pytest.mark.slow
def test_what_tells_nothing_of_this_arm_is_refused(
    panda: Robot, other: Calibration, tmp_path
) -> None:
    files = other.save(tmp_path / "one")
    ur5e = load_robot("ur5e")
    with pytest.raises(UsageError, match="of an arm with the joints panda_joint1"):
        type_priors([files["calibration"]], [ur5e])
    document = json.loads((tmp_path / "one" / "calibration.json").read_text())
    document["deflection"] = {}
    (tmp_path / "rigid.json").write_text(json.dumps(document))
    with pytest.raises(UsageError, match=r"rigid.json: no elasticity was found in that arm"):
        type_priors([tmp_path / "rigid.json"], [panda])


@pytest.mark.parametrize("text", [None, "no JSON", '{"format": "other-1"}'])
def test_a_file_of_another_kind_is_told_which_kinds_are_read(panda: Robot, text, tmp_path) -> None:
    if text is not None:
        (tmp_path / "bad.json").write_text(text)
    with pytest.raises(DocumentError, match=r"a calibration\.json or elasticity\.json"):
        type_priors([tmp_path / "bad.json"], [panda])
