"""``check`` and ``solve`` judge recordings alike, trained on or held out."""

import json
from shutil import copytree

import numpy as np
import pytest
from altered import moved, write_rows
from recorded import RIGID

import mukca

pytestmark = pytest.mark.slow
OF_RECORDINGS = ("data_checks", "distance_given", "scale", "samples")
ALARM = "the base moved before sample 5"
HELD_OUT = "only the test used"
EXITS = {"fail": 1, "not enough": 3}


def drifting(turn):
    """The base turns about the first joint, steadily."""
    return lambda q: q + turn * np.outer(np.arange(len(q)) / len(q), np.eye(7)[0])


def pushed(turn):
    """The base turns about the first joint before the last eight samples."""
    return lambda q: q + turn * np.outer(np.arange(len(q)) >= len(q) - 8, np.eye(7)[0])


def off(zero):
    return lambda q: q + zero * np.eye(7)[3]


def scattered(turn):
    """Every joint errs."""
    return lambda q: q + np.random.default_rng(1).normal(0, turn, q.shape)


def by_name(findings):
    """Levels of findings and their sentences, by what was seen and where."""
    return {(f["code"], f["where"], f["text"]): f for f in findings}


def without(findings, weighed):
    """Those of which the fit does not know more."""
    others = (f for f in findings if not f["where"].startswith(tuple(weighed)))
    return by_name(others)


@pytest.mark.parametrize(
    ("spoil", "distance", "keep"),
    [
        (off(0.0), 0.05, False),
        (off(0.0), 0.0503, False),
        (off(0.1), 0.05, False),
        (drifting(3e-3), 0.05, False),
        (pushed(1e-2), 0.05, False),
        (pushed(1e-2), 0.05, True),
        (scattered(0.03), 0.05, False),
    ],
)
def test_check_and_solve_agree(panda, session, tmp_path, command, spoil, distance, keep):
    """The same findings, set right or as recorded, and the exit status of the same rows."""
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
    words = ("check", folder, "--robot", "panda", "--json", *["--as-recorded"] * keep)
    status, out, _ = command(*words)
    found = json.loads(out)
    seen = [*found["findings"], *(f for p in found["placements"] for f in p["findings"])]
    assert sum(ALARM in finding["text"] for finding in seen) == 3
    placements = mukca.read_placements(folder)
    others = [p for p in placements if p.place != "left"]
    for trained in (placements, others):
        held_out = [p for p in placements if p not in trained]
        calibration = mukca.calibrate(panda, trained, test=held_out, as_recorded=keep, **RIGID)
        checks = [check.as_dict() for check in calibration.document.checks]
        weighed = [check["where"] for check in checks if check["code"] == "movement"]
        assert not (keep and weighed)
        ours, theirs = (without(found, weighed) for found in (checks, seen))
        assert ours.keys() == theirs.keys()
        for name, finding in theirs.items():
            here = ours[name]
            assert here["level"] == finding["level"] or HELD_OUT in here["advice"], here
        verdict = calibration.verdict
        rows = {row.name: row.status for row in (*verdict.limits, *verdict.reasons)}
        if not held_out:
            assert weighed or ours == theirs
            said = {EXITS.get(rows.get(name, ""), 0) for name in OF_RECORDINGS}
            assert status == next((code for code in (1, 3) if code in said), 0)
