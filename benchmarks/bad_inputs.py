"""What the verbs say to bad input: a table, one row for each mistake.

    python benchmarks/bad_inputs.py [--only WORD]

A simulated Panda is recorded at two places; then one thing is spoilt, and it is calibrated on the
first and tested on the second. Other verbs get bad files beside a calibration of it. Whatever comes
out may be no PASS, no status 0 of another verb, no traceback and no NaN. Exit status 1 if something
is.
"""

import argparse
import contextlib
import io
import os
import re
import shutil
import sys
import tempfile
import traceback
from collections.abc import Callable
from pathlib import Path

import numpy as np
from worlds import bad_files

import mukca
from mukca.recorder import write_holes
from mukca.solver.identification.robot import shipped_robots
from mukca.tools.cli import main as mukca_main
from mukca.tools.simulation import Base, perturb, record

ALONG_Y, EYE = np.array([0.0, 1.0, 0.0]), np.eye(7)
FAST = ["--without", "compliance", "tilt", "transmission"]
Spoil = Callable[[Path], list[str] | None]
"""Spoils the recordings in a folder; returns other options, if it takes some."""


def rows_of(file: Path) -> np.ndarray:
    return np.loadtxt(file, delimiter=",", ndmin=2)


def write(file: Path, rows: np.ndarray) -> None:
    np.savetxt(file, rows, delimiter=",", fmt="%.8f")


def all_rows(change: Callable[[np.ndarray], np.ndarray], *, of: str = "*") -> Spoil:
    """Change the samples of each socket, of one placement or of all."""

    def spoil(folder: Path) -> None:
        for file in sorted(folder.glob(f"{of}/hole_*.csv")):
            write(file, change(rows_of(file)))

    return spoil


def text(words: bytes, file: str = "front/hole_0.csv") -> Spoil:
    return lambda folder: (folder / file).write_bytes(words) and None


def first_line(words: str) -> Spoil:
    """Put a line before the samples."""

    def spoil(folder: Path) -> None:
        file = folder / "front/hole_0.csv"
        file.write_text(f"{words}\n{file.read_text()}")

    return spoil


def cell(words: str) -> Spoil:
    """Replace a number in the third line."""

    def spoil(folder: Path) -> None:
        file = folder / "front/hole_0.csv"
        lines = file.read_text().splitlines()
        lines[2] = ",".join([words, *lines[2].split(",")[1:]])
        file.write_text("\n".join(lines))

    return spoil


def options(*words: str) -> Spoil:
    return lambda _: list(words)


def flipped(joint: int) -> Spoil:
    return all_rows(lambda q: q * np.where(np.arange(7) == joint, -1, 1))


def shifted(joint: int, angle: float) -> Spoil:
    return all_rows(lambda q: q + angle * np.eye(7)[joint])


def alike(q: np.ndarray) -> np.ndarray:
    order = np.argsort(np.abs(q - np.median(q, axis=0)).max(axis=1))
    return q[np.sort(order[:8])]


def noisy(q: np.ndarray) -> np.ndarray:
    return q + np.random.default_rng(0).normal(0, 5e-3, q.shape)


def guided(
    count: int, *places: tuple[float, float, float], distance: float = 0.05
) -> np.ndarray:
    """Samples of the arm in the two sockets of a base, at one place after the other."""
    generator = np.random.default_rng(9)
    parts = [
        record(
            ARM,
            Base("b", np.array(at), ALONG_Y, distance),
            generator,
            samples=count,
            noise=5e-5,
        )
        for at in places
    ]
    return np.concatenate([part.positions for part in parts])


def base_moved(folder: Path) -> None:
    after = guided(10, (0.503, 0.002, 0.1))
    file = folder / "front/hole_1.csv"
    write(file, np.concatenate([rows_of(file)[:10], after[10:]]))


def base_moved_between(folder: Path) -> None:
    write(folder / "front/hole_1.csv", guided(20, (0.5, 0.2, 0.1))[20:])


def all_in_one_socket(folder: Path) -> None:
    write(folder / "front/hole_1.csv", guided(20, (0.5, 0.0, 0.1))[:20])


def exchange(folder: Path) -> None:
    """Every fourth sample of socket 0 is in the file of socket 1, and the other way round."""
    files = [folder / f"front/hole_{k}.csv" for k in (0, 1)]
    a, b = map(rows_of, files)
    a[::4], b[::4] = b[::4].copy(), a[::4].copy()
    write(files[0], a)
    write(files[1], b)


def other_placement(folder: Path) -> None:
    shutil.copy(folder / "left/hole_1.csv", folder / "front/hole_1.csv")


def delete(name: str) -> Spoil:
    def spoil(folder: Path) -> None:
        path = folder / name
        shutil.rmtree(path) if path.is_dir() else path.unlink()

    return spoil


def copied(source: str, target: str) -> Spoil:
    def spoil(folder: Path) -> None:
        (shutil.copytree if (folder / source).is_dir() else shutil.copy)(
            folder / source,
            folder / target,
            **({"dirs_exist_ok": True} if "." not in source else {}),
        )

    return spoil


def broken_urdf(words: str) -> Spoil:
    def spoil(folder: Path) -> list[str]:
        (folder / "arm.urdf").write_text(words)
        return ["--robot", str(folder / "arm.urdf")]

    return spoil


def panda_urdf(pattern: str, new: str) -> Spoil:
    """The shipped Panda with each text of a pattern replaced."""
    return broken_urdf(re.sub(pattern, new, shipped_robots()["panda"].read_text()))


def occupied(folder: Path) -> list[str]:
    (folder / "out").mkdir()
    (folder / "out" / "calibration.json").write_text("mine")
    return ["--out", str(folder / "out")]


def copied_and_rounded(folder: Path) -> None:
    """What is held out is what is trained on, in another order, by way of a spreadsheet."""
    for name in ("hole_0.csv", "hole_1.csv"):
        write(folder / "left" / name, rows_of(folder / "front" / name)[::-1])


def homed_again(folder: Path) -> None:
    """Joint 4 gets another zero amid the recording."""
    for file in sorted(folder.glob("front/hole_*.csv")):
        later = np.arange(len(rows_of(file))) >= 10
        write(file, rows_of(file) + 0.03 * np.outer(later, np.arange(7) == 3))


def utf_16(folder: Path) -> None:
    file = folder / "front/hole_0.csv"
    file.write_bytes(file.read_text().encode("utf-16"))


def utf_16_urdf(folder: Path) -> list[str]:
    text_of_panda = shipped_robots()["panda"].read_text()
    (folder / "arm.urdf").write_bytes(text_of_panda.encode("utf-16")[:5001])
    return ["--robot", str(folder / "arm.urdf")]


def tabled(header: list[str], *, scale: float = 1.0, extra: int = 0) -> Spoil:
    """Write all samples below a header, with columns of zeros behind the joints."""

    def spoil(folder: Path) -> None:
        for file in sorted(folder.glob("*/hole_*.csv")):
            q = rows_of(file)
            write(file, np.c_[scale * q, np.zeros((len(q), extra))])
            file.write_text(f"{','.join(header)}\n{file.read_text()}")

    return spoil


def a_turn_on(folder: Path) -> None:
    """Joint 7 stands still, but gained a turn amid each socket."""
    for file in sorted(folder.glob("*/hole_*.csv")):
        q = rows_of(file)
        q[:, 6] = 0.5 + 2 * np.pi * (np.arange(len(q)) >= 10)
        write(file, q)


def cut_off(folder: Path) -> None:
    file = folder / "front/hole_0.csv"
    file.write_text("\n".join([*file.read_text().splitlines()[:8], "0.1, 0.2"]))


def all_text(word: str) -> Spoil:
    """Put a word in the place of the last joint, row by row, below no header."""

    def spoil(folder: Path) -> None:
        for file in sorted(folder.glob("*/hole_*.csv")):
            lines = [line.rpartition(",")[0] for line in file.read_text().splitlines()]
            file.write_text("".join(f"{line},{word}\n" for line in lines))

    return spoil


def decimal_commas(folder: Path) -> None:
    file = folder / "front/hole_0.csv"
    file.write_text(file.read_text().replace(".", ","))


def replaced(make: Callable[[Path], object]) -> Spoil:
    """Put something else in the place of a file of samples."""

    def spoil(folder: Path) -> None:
        file = folder / "front/hole_0.csv"
        file.unlink()
        make(file)

    return spoil


def sparse(size: int) -> Callable[[Path], object]:
    """Make a file that is as long as that, and takes no room."""

    def make(file: Path) -> None:
        with file.open("wb") as stream:
            stream.truncate(size)

    return make


PANDA = [f"panda_joint{k}" for k in range(1, 8)]
MISTAKES: dict[str, Spoil] = {
    "an empty file": text(b""),
    "a header alone": text(b"q1,q2,q3,q4,q5,q6,q7\n"),
    "eight samples three times": all_rows(lambda q: np.repeat(q[:8], 3, axis=0)),
    "one sample in a socket": all_rows(lambda q: q[:1], of="front"),
    "a file of socket 1 missing": delete("front/hole_1.csv"),
    "an empty folder": delete("front"),
    "a word in a cell": cell("closed"),
    "NaN in a cell": cell("nan"),
    "infinity in a cell": cell("inf"),
    "an empty cell": cell(""),
    "1e6 rad in a cell": cell("1000000"),
    "a row too long": cell("0.1,0.2"),
    "six columns": all_rows(lambda q: q[:, :6]),
    "eight columns": all_rows(lambda q: np.c_[q, q[:, 0]]),
    "a time before the joints": all_rows(lambda q: np.c_[np.arange(len(q)), q]),
    "degrees": all_rows(np.rad2deg),
    "columns of another robot's names": first_line("a1,a2,a3,a4,a5,a6,a6"),
    "the columns reversed": all_rows(lambda q: q[:, ::-1]),
    "bytes that are no text": text(bytes(range(256)) * 4),
    "a damaged placement.json": text(b"{", "front/placement.json"),
    "a placement.json with 5 m": text(b'{"distance": 5}', "front/placement.json"),
    "all samples zero": all_rows(lambda q: 0 * q),
    "all samples the same": all_rows(lambda q: np.tile(q[:1], (len(q), 1))),
    "hole_1 a copy of hole_0": copied("front/hole_0.csv", "front/hole_1.csv"),
    "front is a copy of left": copied("left", "front"),
    "hole_1 is left's": other_placement,
    "all in one socket": all_in_one_socket,
    "every fourth in the other socket": exchange,
    "base moved by 3.6 mm amid socket 1": base_moved,
    "base moved between its sockets": base_moved_between,
    "joint 2's sign": flipped(1),
    "joint 4's sign": flipped(3),
    "joint 6's sign": flipped(5),
    "the last joint's sign": flipped(6),
    "columns 3 and 5 exchanged": all_rows(lambda q: q[:, [0, 1, 4, 3, 2, 5, 6]]),
    "columns 6 and 7 exchanged": all_rows(lambda q: q[:, [0, 1, 2, 3, 4, 6, 5]]),
    "joint 3's zero off by 0.5 rad": shifted(2, 0.5),
    "joint 5's zero off by a quarter": shifted(4, np.pi / 2),
    "joint 4's zero off by 0.1 rad": shifted(3, 0.1),
    "joint 6's zero off by 0.1 rad": shifted(5, 0.1),
    "zeros of joints 2 and 4 off": all_rows(lambda q: q + 0.1 * EYE[1] - 0.15 * EYE[3]),
    "joint 3's sign, and joint 4's zero": all_rows(
        lambda q: q * (1 - 2 * EYE[2]) + 0.1 * EYE[3]
    ),
    "columns 3 and 5, and joint 2's zero": all_rows(
        lambda q: q[:, [0, 1, 4, 3, 2, 5, 6]] + 0.12 * EYE[1]
    ),
    "joint 4 homed again amid the recording": homed_again,
    "held out is trained on, rounded": copied_and_rounded,
    "another distance in one placement.json": text(
        b'{"distance": 0.0512}', "left/placement.json"
    ),
    "angles from 0 to 360 degrees": all_rows(lambda q: q % (2 * np.pi)),
    "angles rounded to degrees": all_rows(
        lambda q: np.deg2rad(np.round(np.rad2deg(q)))
    ),
    "joint 2 always zero": all_rows(lambda q: q * (np.arange(7) != 1)),
    "a counter for the last joint": all_rows(
        lambda q: np.c_[q[:, :6], np.arange(len(q)) / 10]
    ),
    "each of four samples five times": all_rows(lambda q: np.repeat(q[:4], 5, axis=0)),
    "each of six samples five times": all_rows(lambda q: np.repeat(q[:6], 5, axis=0)),
    "joint 7 still, but for a turn": a_turn_on,
    "two arms in one file": tabled(
        [f"{arm}_{n}" for arm in "ab" for n in PANDA], extra=7
    ),
    "a joint's column twice": tabled([*PANDA, PANDA[0]], extra=1),
    "one joint's name wrong": tabled([*PANDA[:6], "tool"]),
    "velocities alone": tabled([f"{n}_velocity" for n in PANDA]),
    "commands alone": tabled([f"target_q_{k}" for k in range(7)]),
    "degrees that are said to be radians": tabled(
        [f"{n} [rad]" for n in PANDA], scale=57.29578
    ),
    "a unit that no joint has": tabled([f"{n} [N]" for n in PANDA]),
    "UTF-16": utf_16,
    "cut off amid a line": cut_off,
    "decimal commas, separated by commas": decimal_commas,
    "a folder in the place of a file": replaced(Path.mkdir),
    "a FIFO in the place of a file": replaced(os.mkfifo),
    "a link to a device that never ends": replaced(
        lambda file: file.symlink_to("/dev/zero")
    ),
    "a link to nowhere": replaced(lambda file: file.symlink_to("nowhere")),
    "a file of 201 MB": replaced(sparse(201_000_000)),
    "10,001 columns": all_rows(lambda q: np.tile(q, (1, 1429))[:, :10_001], of="front"),
    "a cell of 1 MB": cell("9" * 1_000_000),
    "a name of 1 MB": first_line(f"{'j' * 1_000_000},b,c,d,e,f,g"),
    "a name of control characters": first_line("\x1b[2J\x07,b,c,d,e,f,g"),
    "an image's name in each row": all_text("front.png"),
    "5 mrad of noise on each joint": all_rows(noisy),
    "3 samples a socket": all_rows(lambda q: q[:3]),
    "5 samples a socket": all_rows(lambda q: q[:5]),
    "3 samples a socket held out": all_rows(lambda q: q[:3], of="left"),
    "the eight most alike": all_rows(alike),
    "joint 5 held still": all_rows(
        lambda q: np.where(np.arange(7) == 4, q.mean(axis=0), q)
    ),
    "--distance 0.12": options("--distance", "0.12"),
    "--distance 0.051": options("--distance", "0.051"),
    "--distance 0.048": options("--distance", "0.048"),
    "--distance 0.0505": options("--distance", "0.0505"),
    "--distance 50": options("--distance", "50"),
    "--distance -0.05": options("--distance", "-0.05"),
    "--distance nan": options("--distance", "nan"),
    "--known to no socket": options("--known", "front:0-back:0=0.4"),
    "--known in no form": options("--known", "0.4"),
    "--known 10 mm wrong": options("--known", "front:0-front:1=0.06"),
    "--payload -1": options("--payload", "-1"),
    "--payload in grams": options("--payload", "5000"),
    "--ball in millimetres": options(
        "--flange", "panda_link8", "--ball", "0", "0", "70"
    ),
    "a ball 3 m from its flange": options(
        "--flange", "panda_link8", "--ball", "0", "0", "3"
    ),
    "an xacro without its prefix": panda_urdf(
        "<robot", '<robot xmlns="x"><macro/></robot><robot'
    ),
    "a URDF in UTF-16 that is cut off": utf_16_urdf,
    "a URDF of 21 MB": broken_urdf(" " * 21_000_000),
    "a link as often as there are": panda_urdf(
        "</robot>", '<link name="panda_link8"/></robot>'
    ),
    "a placement.json nested without end": text(
        b"[" * 1_000_000, "front/placement.json"
    ),
    "an arm's log in the place of samples": text(b"0,0,0,0,0,0,0\n" * 200_000),
    "the lines of two programs": first_line("17,100,base,elbow,wrist,0.5,0.7"),
    "--gravity 0 0 0": options("--gravity", "0", "0", "0"),
    "--repeatability-mm 0": options("--repeatability-mm", "0"),
    "--free nothing": options("--free", "elbow"),
    "another arm's model (iiwa 14)": options("--robot", "iiwa14"),
    "another arm's model (UR5e)": options("--robot", "ur5e"),
    "no such robot": options("--robot", "pandda"),
    "no such tip": options("--tip", "finger"),
    "a URDF that is no XML": broken_urdf("<robot"),
    "a URDF without joints": broken_urdf('<robot name="r"><link name="a"/></robot>'),
    "a Git LFS pointer": broken_urdf("version https://git-lfs.github.com/spec/v1\n"),
    "a xacro file": panda_urdf(r'rpy="', 'rpy="${turn} '),
    "a URDF in degrees": panda_urdf(r"1\.5707\d*", "90"),
    "a URDF in millimetres": panda_urdf(r"\b0\.333\b", "333"),
    "a URDF in grams": panda_urdf(r'mass value="([\d.]+)"', r'mass value="\g<1>e3"'),
    "limits 0 to 0": panda_urdf(r'lower="[^"]*" upper="[^"]*"', 'lower="0" upper="0"'),
    "a floating base": panda_urdf(
        r'(<joint name="panda_base_joint" type=)"fixed"', r'\1"floating"'
    ),
    "results that are there already": occupied,
}


def said(folder: Path, spoil: Spoil) -> tuple[int, str, bool]:
    """Return the exit status, what was said in short, and whether that may not be."""
    given = spoil(folder) or []
    robot = [] if "--robot" in given else ["--robot", "panda"]
    words = [
        "solve",
        str(folder / "front"),
        "--test",
        str(folder / "left"),
        *robot,
        *FAST,
        *given,
    ]
    status, told = run(words, folder)
    lines = [line.strip() for line in told.splitlines() if line.strip()]
    verdict = [line for line in lines if line.startswith("Verdict:")]
    reasons = [
        line
        for line in lines
        if re.match(r"(warning|error|mukca|Fail|Not enough)", line)
    ]
    short = "; ".join([*verdict, *(reasons or lines[-1:])[:2]])
    passed = any("PASS" in line and "FAIL" not in line for line in verdict)
    return status, short, passed or broken(status, told)


def answered(folder: Path, mistake: bad_files.Mistake) -> tuple[int, str, bool]:
    """Return the same of another verb, which may not end with status 0."""
    status, told = run(mistake(folder), folder)
    lines = [line.strip() for line in told.splitlines() if line.strip()]
    reasons = [
        line for line in lines if re.match(r"(warning|mukca|NOT|No |[\d.]+ to )", line)
    ]
    return (
        status,
        "; ".join((reasons or lines[-1:])[:2]),
        status == 0 or broken(status, told),
    )


def broken(status: int, told: str) -> bool:
    """Return whether an answer is a defect of the program, or holds no number."""
    numbers = re.sub("distance nan|is nan, not", "", told)
    nan = re.search(r"\bnan\b", numbers, re.IGNORECASE)
    return status == 70 or bool(nan) or "Traceback" in told


def run(words: list[str], folder: Path) -> tuple[int, str]:
    """Return the exit status of a command, and what it says, or the last line of a traceback."""
    out = io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
            status = mukca_main(words)
    except SystemExit as stop:
        status = int(stop.code or 0)
    except Exception:
        return 70, traceback.format_exc().splitlines()[-1]
    return status, out.getvalue().replace(f"{folder}/", "").replace(
        str(folder), "FOLDER"
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--only", default="", metavar="WORD", help="mistakes with this in their name"
    )
    arguments = parser.parse_args()
    wrong = 0
    with tempfile.TemporaryDirectory() as start:
        sound = Path(start) / "sound"
        for name, place in (("front", (0.5, 0.0, 0.1)), ("left", (0.35, 0.4, 0.1))):
            base = Base(name, np.array(place), ALONG_Y)
            placement = record(
                ARM, base, np.random.default_rng(1), samples=20, noise=5e-5
            )
            write_holes(placement, sound / name)
        run(
            [
                "solve",
                str(sound),
                "--robot",
                "panda",
                "--out",
                str(sound / "calibrated"),
            ],
            sound,
        )
        print("| what was done | status | what was said |\n|---|---|---|")
        rows = [(mistake, said, spoil) for mistake, spoil in MISTAKES.items()]
        rows += [
            (mistake, answered, spoil) for mistake, spoil in bad_files.MISTAKES.items()
        ]
        for i, (mistake, answer, spoil) in enumerate(rows):
            if arguments.only not in mistake:
                continue
            folder = Path(shutil.copytree(sound, Path(start) / str(i)))
            status, short, bad = answer(folder, spoil)
            wrong += bad
            print(
                f"| {mistake} | {status} | {'WRONG: ' * bad}{short.replace('|', '/')} |",
                flush=True,
            )
    print(f"\n{len(rows)} mistakes, {wrong} answered wrongly", file=sys.stderr)
    return 1 if wrong else 0


ROBOT = mukca.load_robot("panda")
ARM = perturb(ROBOT, np.random.default_rng(7), 1e-3, 3e-3)

if __name__ == "__main__":
    raise SystemExit(main())
