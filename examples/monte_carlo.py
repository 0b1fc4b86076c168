"""How many samples are enough? A Monte Carlo study on simulated arms whose truth is known.

Each arm differs from its URDF at random. It is calibrated on one placement with more and more
samples. Two figures judge it: the error at two held-out placements, as anyone can measure it;
and the error of distances between ball positions, which only the truth can tell.

    python monte_carlo.py
    python monte_carlo.py 10  5 10 20 40    # arms, then numbers of samples
"""

import sys

import numpy as np

import mukca

robot = mukca.load_robot("panda")
arms, *counts = [int(word) for word in sys.argv[1:]] or [4, 6, 12, 24]


def distances(balls: np.ndarray) -> np.ndarray:
    """Return how far each ball position is from the next, shape (N - 1,) [m]."""
    return np.sqrt(np.sum(np.diff(balls, axis=0) ** 2, axis=1))


print("samples a socket   held-out error   error of distances   (median of arms, mm)")
for samples in counts:
    held_out, true = list[float](), list[float]()
    for seed in range(arms):  # the same arms for every number of samples
        truth, places = mukca.simulate_recordings(robot, 3, samples=samples, seed=seed)
        train, *test = places
        calibration = mukca.calibrate(robot, train, test=test)
        summary = calibration.errors.summary.test
        held_out.append(summary.calibrated.mean_absolute_error if summary else np.nan)
        q = np.concatenate([p.positions for p in test])
        q = np.random.default_rng(seed).permutation(q)
        errors = distances(calibration.ball(q)) - distances(truth.ball(q))
        true.append(float(abs(errors).mean()))
    medians = 1e3 * np.median([held_out, true], axis=1)
    print(f"{samples:16d} {medians[0]:16.3f} {medians[1]:20.3f}", flush=True)
