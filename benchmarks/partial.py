"""One thing fitted with the calibrated chain held: the figures of docs/hold.md.

python benchmarks/partial.py rezero RECORDINGS    5 mrad put into a real arm's joints (panda_3)
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import mukca

TRAINED = ("frontcenter", "backleft")
PUT_IN = 5e-3


def rezero(folder: Path, draws: int) -> Iterator[str]:
    """Zeros put into held-out samples of a real arm, 6 in each socket."""
    placements = mukca.read_placements(folder)
    train = [p for p in placements if p.name.endswith(TRAINED)]
    others = [p for p in placements if p not in train]
    calibration = mukca.calibrate(mukca.load_robot(folder / "nominal.urdf"), train)
    names, generator = calibration.robot.joint_names, np.random.default_rng(0)
    wrong = 0
    found: dict[int, list[tuple[float, float, bool]]] = {j: [] for j in range(1, len(names) - 1)}
    for draw in range(draws):
        since = few(others[draw % len(others)], 6, generator)
        wrong += bool(mukca.rezero(calibration, since).changed)
        for j, rows in found.items():
            q = since.positions - PUT_IN * np.eye(len(names))[j]
            moved = mukca.Placement.of_arrays("since", q, since.sockets, names, distance=0.05)
            told = [one.joint for one in mukca.rezero(calibration, moved).changed]
            zero = mukca.rezero(calibration, moved, [names[j]]).joints[j]
            rows.append((zero.offset - PUT_IN, zero.standard_deviation, told == [names[j]]))
    yield f"none put in: some named in {wrong} of {draws}"
    for j, rows in found.items():
        rms = (sum(off**2 for off, _, _ in rows) / draws) ** 0.5
        stated = sum(deviation for _, deviation, _ in rows) / draws
        yield (
            f"{names[j]}: rms {1e3 * rms:.2f} mrad, stated {1e3 * stated:.2f}, "
            f"named in {sum(told for _, _, told in rows)} of {draws}"
        )


def few(placement: mukca.Placement, count: int, generator: np.random.Generator) -> mukca.Placement:
    """Return some samples of each socket of a placement."""
    sockets = placement.sockets
    rows = np.concatenate(
        [generator.choice(np.flatnonzero(sockets == k), count, replace=False) for k in (0, 1)]
    )
    q, names = placement.positions[rows], placement.joint_names
    return mukca.Placement.of_arrays("since", q, sockets[rows], names, distance=0.05)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("rezero",))
    parser.add_argument("recordings", type=Path, nargs="?")
    parser.add_argument("--draws", type=int, default=30)
    arguments = parser.parse_args()
    for line in rezero(arguments.recordings, arguments.draws):
        print(line, flush=True)


if __name__ == "__main__":
    main()
