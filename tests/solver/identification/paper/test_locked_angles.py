"""A pitch near 90 degrees leaves roll, pitch and yaw two turns, and the paper's method says so."""

import mukca


def test_the_papers_method_warns_of_a_pitch_near_90_degrees():
    robot = mukca.load_robot("lite6")
    _, train = mukca.simulate_recordings(robot, 1, samples=10)
    by_paper, by_default = (mukca.calibrate(robot, train, method=m) for m in ("paper", "auto"))
    assert any("joint2: a pitch near 90" in line for line in by_paper.document.warnings)
    assert not any("pitch" in line for line in by_default.document.warnings)
    assert by_paper.document.rotation_numbers == "rpy"
    assert by_default.document.rotation_numbers == "vector"
