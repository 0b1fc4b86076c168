"""Writes the pages of docs/causes: one for each explanation that the program compares.

    python docs/causes/pages.py

Line, step and prior probability are those of the program's own table, with numbers put in; only
the words on how a cause looks are written here.
"""

from dataclasses import replace
from pathlib import Path

from mukca.solver.diagnostics import CAUSES

HERE = Path(__file__).parent
EXAMPLE = {
    "joint": "joint_4", "turn": "once", "postures": 2,
    "component": "z", "placement": "front", "socket": 0, "sample": 17,
    "place": 18, "last": 19, "last_place": 20,
    "samples": 3, "other": 1, "of": "left", "of_socket": 0, "noise": 1.2e-3,
    "noise_here": 2.1e-3, "size": 2e-3, "share": 0.02, "given": 0.051, "expected": 0.05,
    "likely": 0.05, "offset": 0.02, "error": 8e-3, "sense": "too large", "step": 0.01,
    "known": "front:0-left:0=0.4",
    "gravity": [0.0, 0.0, 9.81], "option": "0 0 9.81",
    "columns": "q=1,2,3,-4,5,6,7",
    "source": "as you gave it: measure it again and pass the reading with --distance",
}  # fmt: skip
POINT = {**EXAMPLE, "point": 18}
LOOKS = {
    "distance": "Every fit is as good as ever, and the arm comes out too long or too short: its "
    "size follows the distance that was typed. It looks the same as a model that is scaled.",
    "scaled": "As with a wrong distance, the arm comes out too long or too short: no recording "
    "tells the two apart.",
    "one_socket": "The centres of both sockets come out at one place.",
    "known": "One of the distances given by `--known` does not fit the model and all others.",
    "length": "The samples scatter in a pattern that one length explains, in all placements alike. "
    "The arm often comes out too long or too short, too.",
    "angle": "The samples scatter in a pattern that one angle of the model explains. An angle "
    "about a joint's axis is the zero of that joint.",
    "version": "Errors are large. No single number of the model explains them, but many together "
    "do.",
    "other_arm": "Each placement fits well by itself. Together they do not fit.",
    "zero": "The samples scatter in a pattern that one joint's offset explains, in all placements.",
    "zero_lost": "All samples fit up to one, and from that sample on one joint is off: it lost "
    "steps, slipped, or was homed again.",
    "gain": "One joint's error grows with its angle: a gear ratio, or a wrong unit.",
    "uneven": "One joint's error is a wave of its angle: an encoder or a gear off its axis.",
    "soft_base": "Errors grow as the arm reaches out, to each side: its base tilts under its "
    "weight.",
    "repeated": "Most samples of a placement are in a few postures, recorded again and again.",
    "stuck": "One joint reads the same to the last digit while the others move.",
    "commands": "Errors grow with each joint's load, in all joints by one share: servos sag below "
    "what they are told, and a file of goals does not hold that.",
    "lag": "Each sample is off towards the one before it: it was taken before the arm stood still.",
    "base_moved": "From one sample on all balls are displaced alike in space.",
    "base_tipped": "Some samples in a row are displaced alike in space. Those before and "
    "after them fit.",
    "base_between": "The samples fit, but the sockets of one base come out at another distance "
    "than stated. Those of the other bases do not.",
    "drift": "Errors grow steadily in the order of recording: a base that creeps, a table that "
    "gives way, an arm that warms up.",
    "ball_sample": "One sample is far from all others of its socket.",
    "ball_bent": "From one sample on the ball sits elsewhere on its flange: errors turn with it.",
    "ball_loose": "All samples scatter more than the arm repeats, alike in every direction.",
    "socket": "Samples lie at the centre of another socket than their file or column says.",
    "mounting": "Errors look as if the arm bent against its loads: gravity was stated along a "
    "wrong axis, so the fit would need negative elasticity.",
    "copies": "The samples of one socket are those of another, as good as digit by digit.",
    "quantised": "The file holds few digits: all angles of a joint are multiples of one step.",
    "pushed": "All samples scatter more than the arm repeats, and most where joints have long "
    "levers: a hand held the arm against its gears.",
    "unexplained": "Errors are large, and no other cause of this list is likely.",
    "sign": "One joint or several count the other way round than the model. Servo arms whose file "
    "has another calibration format differ by quarter turns, too.",
    "swap": "The columns of two joints are exchanged.",
    "order": "The columns come in another order than the chain's joints: turned round, shifted.",
    "ratio": "One joint reads a whole multiple of its angle, or a part of it: a gear that its "
    "driver leaves out.",
    "coupled": "One joint's column holds a sum of two angles: a parallel rod, or a pendant that "
    "counts from the horizontal, as a Fanuc's does.",
}
"""How each looks in recordings."""
OF_COLUMNS = {
    "sign": "joint 4 (joint_4) looks sign-flipped: with the other sign the error falls "
    "from 63 to 0.11 mm",
    "swap": "joints 2 and 3 (joint_2, joint_3) look swapped: with their columns put right the "
    "error falls from 63 to 0.11 mm",
    "order": "the columns look out of order: 7, 6, 5, 4, 3, 2, 1: with their columns put right the "
    "error falls from 410 to 0.11 mm",
    "ratio": "joint 3 (joint_3) looks wrongly geared: with 6 q the error falls from 290 to 0.11 mm",
    "coupled": "joints 3 and 2 (joint_3, joint_2) look coupled: with joint_3 + joint_2 for joint_3 "
    "the error falls from 290 to 0.11 mm",
}
TITLES = {"known": "Known distance wrong", "order": "Columns out of order"}


def main() -> None:
    rows: list[str] = []
    total = 1 + sum(cause.prior for cause in CAUSES)
    for name in dict.fromkeys(cause.name for cause in CAUSES):
        own = [cause for cause in CAUSES if cause.name == name]
        lines = [c.text(EXAMPLE) or OF_COLUMNS.get(name, "") for c in own]
        lines = [line for line in dict.fromkeys(lines) if line]
        prior = 100 * sum(cause.prior for cause in own) / total
        title = TITLES.get(name, name.replace("_", " ").capitalize())
        of_points = [replace(c, **c.of_points).text(POINT) for c in own if c.of_points]
        told = "\n".join(f"- `{line}`" for line in lines)
        if of_points:
            told += "\n\nOf points that an instrument measured:\n\n"
            told += "\n".join(f"- `{line}`" for line in of_points)
        todo = list(dict.fromkeys(_step(c) for c in own))
        tells = list(dict.fromkeys(c.tell for c in own if c.tell))
        tell = " Or: ".join(_sentence(one) for one in tells)
        (HERE / f"{name}.md").write_text(
            f"# {title}\n\nThe program says, for example:\n\n{told}\n\n"
            f"**How it looks.** {LOOKS[name]}\n\n**To tell it from others.** {tell}\n\n"
            f"**What to do.** {' '.join(todo)}\n\n"
            f"Before the data are seen, its probability is {prior:.2g} %. "
            "[All causes](index.md)\n"
        )
        rows.append(
            f"| [{title}]({name}.md) | {LOOKS[name].partition(': ')[0].rstrip('.')} |"
        )
    page = HERE / "index.md"
    head, mark, rest = page.read_text().partition("|---|---|\n")
    after = rest[rest.index("\n\n") :]
    page.write_text(head + mark + "\n".join(rows) + after)


def _step(kind) -> str:
    """What to do; of one placement that scatters more than others, it says so."""
    step = kind.advice.format(**EXAMPLE)
    return _sentence(
        f"If it is one placement alone: {step}" if "noise_here" in kind.form else step
    )


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:].rstrip('.?')}{'?' if words.endswith('?') else '.'}"


if __name__ == "__main__":
    main()
