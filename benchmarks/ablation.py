"""What each part of the model is worth: errors at other places, with and without it.

    python benchmarks/ablation.py [PLACEMENTS --robot R] [--arms 15] [--picture FILE.svg]

Every model is trained on the first placement and measured at all others. Without placements, arms
are simulated that bend and turn unevenly as real ones do. `means held` is Eq. (5) of the paper
with the sockets' means held where the nominal model has them, as in methods before it; the paper's
own cost lets them follow the model.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from worlds import TRANSLATION, TURN, realistic_flaws

from mukca.recorder import find_placements, read_placement
from mukca.solver.calibration import METHODS, SolveOptions, fit_robot
from mukca.solver.identification.data import (
    Measurement,
    evaluate,
    measure,
)
from mukca.solver.identification.paper import REGULARIZATION
from mukca.solver.identification.robot import (
    BallModel,
    Robot,
    choose_parameters,
    load_robot,
)
from mukca.solver.results import Measurements
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import perturb, reachable_bases, record

ROBOTS = ("panda", "iiwa14", "ur5e")
EXTENSIONS = ("compliance", "tilt", "play", "transmission")
ROWS = {
    "geometry": (),
    "geometry, compliance": ("compliance",),
    "geometry, tilt": ("tilt",),
    "geometry, transmission": ("transmission",),
    "all": EXTENSIONS,
}
Predict = Callable[[Measurement], np.ndarray]


def means_held(robot: Robot, train: Measurement) -> Predict:
    """Return the model whose balls are nearest to the nominal model's socket means."""
    parameters = choose_parameters(robot)
    model = BallModel(robot, [p.index for p in parameters])
    weight = (
        np.array([0.0 if p.of_ball else REGULARIZATION for p in parameters]) + 1e-12
    )
    rows = [model.points(model.nominal, q) for q in train.by_socket]
    target = np.concatenate([np.tile(p.mean(axis=0), (len(p), 1)) for p in rows])
    q, x = np.concatenate(train.by_socket), np.zeros(len(parameters))
    for _ in range(10):
        linear = model.linearise(model.nominal + x, q)
        J, N = linear.by_parameters.reshape(-1, len(x)), len(q)
        slope = J.T @ (linear.points - target).ravel() / N + weight * x
        x = x - np.linalg.solve(J.T @ J / N + np.diag(weight), slope)
    return lambda measured: model.points(model.nominal + x, measured.positions)


def errors(robot: Robot, data: Sequence[Measurement]) -> dict[str, float]:
    """Return each model's mean absolute error at all placements but the first [mm]."""
    train, *test = data
    recordings = Measurements(robot, [train])
    by_paper = SolveOptions(method="paper")
    paper = fit_robot(recordings, by_paper, METHODS).calibrated
    models: dict[str, Predict] = {
        "nominal": lambda m: paper.nominal_ball(m.positions),
        "means held": means_held(robot, train),
        "paper": lambda m: paper.ball(m.positions),
    }
    for name, kept in ROWS.items():
        without = [extension for extension in EXTENSIONS if extension not in kept]
        options = SolveOptions(without=without)
        found = fit_robot(recordings, options, METHODS).calibrated
        models[name] = lambda m, found=found: found.ball(m.positions, m.efforts)
        models["URDF alone"] = lambda m, found=found: found.geometric_ball(m.positions)
    return {
        name: 1e3
        * float(np.mean([evaluate(model(m), m).mean_absolute_error for m in test]))
        for name, model in models.items()
    }


def simulated(seed: int) -> tuple[Robot, list[Measurement]]:
    """Return a robot, and recordings of an arm of its type at four places."""
    robot, generator = (
        load_robot(ROBOTS[seed % len(ROBOTS)]),
        np.random.default_rng(seed),
    )
    arm = perturb(robot, generator, TRANSLATION, TURN)
    flaws = realistic_flaws(robot, generator)
    bases = reachable_bases(arm, generator, 4)
    return robot, [
        measure(record(arm, b, generator, imperfection=flaws), robot) for b in bases
    ]


def draw(seed: int) -> dict[str, float]:
    return errors(*simulated(seed))


def picture(rows: dict[str, list[float]], title: str) -> str:
    """Return a bar for each model as SVG; the nominal one would not fit beside the others."""
    shown = {
        name: float(np.mean(values))
        for name, values in rows.items()
        if name != "nominal"
    }
    largest = max(value for name, value in shown.items() if name != "means held")
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 {60 + 26 * len(shown)}" '
        'font-family="sans-serif" font-size="13">',
        '<rect width="100%" height="100%" fill="white"/>',
        f'<text x="10" y="24">{title}</text>',
    ]
    for i, (name, value) in enumerate(shown.items()):
        y, width = 44 + 26 * i, 380 * min(value / largest, 1.05)
        lines += [
            f'<text x="190" y="{y + 14}" text-anchor="end">{name}</text>',
            f'<rect x="200" y="{y}" width="{width:.1f}" height="18" fill="#3b7dd8"/>',
            f'<text x="{206 + width:.1f}" y="{y + 14}">{value:.3f}</text>',
        ]
    return "\n".join([*lines, "</svg>"]) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("placements", nargs="*", type=Path)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--arms", type=int, default=15)
    parser.add_argument("--picture", type=Path)
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    if arguments.placements:
        robot = load_robot(arguments.robot)
        folders = dict.fromkeys(
            p.resolve() for p in find_placements(arguments.placements)
        )
        found = [read_placement(folder) for folder in folders]
        draws = [errors(robot, [measure(p, robot) for p in found])]
        title = f"{robot.name}: mean absolute error at other places, mm"
    else:
        draws = read_options(arguments).workers.map(draw, range(arguments.arms))
        title = f"{len(draws)} simulated arms: mean absolute error at other places, mm"
    rows = {name: [draw[name] for draw in draws] for name in draws[0]}
    print(title)
    for name, values in rows.items():
        better = np.mean([v <= p for v, p in zip(values, rows["paper"], strict=True)])
        print(
            f"{name:24s} {np.mean(values):7.3f}   at or below the paper's: {100 * better:3.0f} %"
        )
    if arguments.picture:
        arguments.picture.write_text(picture(rows, title))


if __name__ == "__main__":
    main()
