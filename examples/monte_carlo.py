"""How many samples are enough? A Monte Carlo study on simulated arms whose truth is known.

Each arm differs from its URDF at random. It is calibrated on one placement with more and more
samples. Two figures judge it: the error at two held-out placements, as anyone can measure it;
and the error of distances between ball positions, which only the truth can tell.

    python monte_carlo.py 10
    python monte_carlo.py 10  5 10 20 40    # other numbers of samples
"""

import sys

import numpy as np

import mukca

robot = mukca.load_robot("panda")
arms = int(sys.argv[1]) if len(sys.argv) > 1 else 4
counts = [int(word) for word in sys.argv[2:]] or [6, 12, 24]


def distances(balls: np.ndarray) -> np.ndarray:
    """Return how far each ball position is from the next, shape (N - 1,) [m]."""
    lengths: np.ndarray = np.linalg.norm(np.diff(balls, axis=0), axis=1)
    return lengths


print("samples a socket   held-out error   error of distances   (median of arms, mm)")
for samples in counts:
    held_out, true = list[float](), list[float]()
    for seed in range(arms):  # the same arms for every number of samples
        truth, drawn = mukca.simulate_recordings(robot, 3, samples=samples, seed=seed)
        train, *test = drawn
        calibration = mukca.calibrate(robot, train, test=test)
        summary = calibration.errors.summary.test
        assert summary is not None  # there are placements apart
        held_out.append(summary.calibrated.mean_absolute_error)
        q = np.concatenate([p.positions for p in test])
        q = np.random.default_rng(seed).permutation(q)
        errors = distances(calibration.ball(q)) - distances(truth.ball(q))
        true.append(float(np.mean(np.abs(errors))))
    medians = 1e3 * np.median([held_out, true], axis=1)
    print(f"{samples:16d} {medians[0]:16.3f} {medians[1]:20.3f}", flush=True)
