"""What is stated of an arm of servos, one of whose zeros differs between placements."""

import numpy as np

import mukca


def test_a_zero_that_differs_in_one_placement_hardly_widens_what_is_stated():
    """The fit has an unknown for it, so the samples' errors are as alike as without."""
    robot = mukca.load_robot("so101")
    settings = {"samples": 14, "distance": 0.1, "noise": 2e-4, "play": 5e-3}
    _, placements = mukca.simulate_recordings(robot, 3, **settings)
    *others, last = placements
    q = last.positions + np.deg2rad(3) * np.eye(5)[2]
    stated = []
    for sound in (last, last.with_positions(q)):
        found = mukca.calibrate(robot, [*others, sound], zeros=True, no_proof=True)
        stated.append(found.document.better.workspace.now.value)
    differences = [c.text for c in found.document.checks if c.code == "movement"]
    assert "elbow_flex reads" in differences[0]
    assert stated[1] < 2 * stated[0]
