"""``check`` and ``solve`` judge recordings alike, trained on or held out."""

import json
from shutil import copytree

import numpy as np
import pytest
from altered import moved, write_rows

import mukca
from mukca.solver.assessment import worst

pytestmark = pytest.mark.slow
OF_RECORDINGS = ("data_checks", "distance_given", "scale", "samples")
ALARM = "the base moved before sample 5"
EXITS = {"fail": 1, "not enough": 3}


def drifting(turn):
    """The base turns about the first joint, steadily."""
    return lambda q: q + turn * np.outer(np.arange(len(q)) / len(q), np.eye(7)[0])


def pushed(turn):
    """The base turns about the first joint before the last eight samples."""
    return lambda q: q + turn * np.outer(np.arange(len(q)) >= len(q) - 8, np.eye(7)[0])


def off(zero):
    return lambda q: q + zero * np.eye(7)[3]


@pytest.mark.parametrize(
    ("spoil", "distance"),
    [
        (off(0.0), 0.05),
        (off(0.0), 0.0503),
        (off(0.1), 0.05),
        (drifting(3e-3), 0.05),
        (pushed(1e-2), 0.05),
    ],
)
def test_check_and_solve_agree(panda, session, tmp_path, command, spoil, distance):
    """The same findings, and the exit status of the same rows.

    What is wrong in a placement that was held out does nothing to the model: its level may differ.
    """
    folder = copytree(session, tmp_path / "session")
    for file in folder.glob("*/placement.json"):
        keys = json.loads(file.read_text())
        said = {"distance": distance, "distance_measured": True, "kept_alarms": [ALARM]}
        file.write_text(json.dumps({**keys, **said}))
    (left,) = mukca.read_placements(folder / "left")
    left = moved(left, spoil(left.positions))
    for socket in (0, 1):
        rows = left.positions[left.sockets == socket].tolist()
        write_rows(folder / f"left/hole_{socket}.csv", rows)
    status, out, _ = command("check", folder, "--robot", "panda", "--json")
    found = json.loads(out)
    said = [*found["findings"], *(f for p in found["placements"] for f in p["findings"])]
    assert sum(ALARM in finding["text"] for finding in said) == 3
    placements = mukca.read_placements(folder)
    others = [p for p in placements if p.place != "left"]
    for trained in (placements, others):
        held_out = [p for p in placements if p not in trained]
        calibration = mukca.calibrate(panda, trained, test=held_out, as_recorded=True)
        checks = [check.as_dict() for check in calibration.document.checks]
        of_fit = ("movement",)
        same = {"code", "where", "text"} if held_out else set(said[0])
        ours, theirs = (
            sorted(str({key: c[key] for key in sorted(same)}) for c in several)
            for several in (said, [c for c in checks if c["code"] not in of_fit])
        )
        assert ours == theirs
        verdict = calibration.verdict
        rows = {row.name: row.status for row in (*verdict.limits, *verdict.reasons)}
        if not held_out:
            assert status == worst(EXITS.get(rows.get(name, ""), 0) for name in OF_RECORDINGS)
