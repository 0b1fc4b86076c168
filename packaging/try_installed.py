"""Do the main job with the mukca that is installed, on the demo's recordings.

    python try_installed.py demo/recordings

Results go to new folders below the present one. `try_wheel.py` runs it by several Pythons, and
under -OO: therefore nothing here is an assert.
"""

import pydoc
import sys
import time
import warnings
from pathlib import Path

import mukca
from mukca.tools.cli import main

LARGEST_ERROR = 2e-4
"""Mean absolute error of the demo arm at the placement held out [m]."""


def run(*words):
    status = main([str(word) for word in words])
    require(status == 0, f"mukca {' '.join(map(str, words))} ended with {status}")


def require(holds, what):
    if not holds:
        sys.exit(what)


def calibrate(recordings, out):
    """Calibrate in Python, write the report, and return the error [m]."""
    train, test = (
        mukca.read_placements(recordings / base) for base in ("front", "left")
    )
    calibration = mukca.calibrate(mukca.load_robot("panda"), train, test=test)
    calibration.save(out)
    run("report", out)
    text = (out / "report.html").read_text(encoding="utf-8")
    require("</html>" in text and "Verdict" in text, "the report is not whole")
    return calibration.errors["left"].calibrated.mean_absolute_error


def record(recordings, out):
    """Record two samples by a script of keys."""
    keys = Path("two_samples.txt")
    keys.write_text("a a q", encoding="utf-8")
    driver = f"mock:{recordings / 'front'}?speed=20"
    run("record", "--robot", "panda", "--driver", driver, "--keys", keys, "--out", out)
    rows = (out / "samples.csv").read_text(encoding="utf-8").splitlines()
    require(len(rows) == 3, f"{len(rows) - 1} samples are recorded instead of 2")


if __name__ == "__main__":
    warnings.filterwarnings("error", module="mukca")
    begin = time.perf_counter()
    stripped = sys.flags.optimize > 1  # -OO takes all docstrings away
    require(
        stripped or "repeatability_mm" in pydoc.render_doc(mukca.calibrate),
        "help lacks the options",
    )
    recordings = Path(sys.argv[1])
    run(
        "solve", recordings / "front", "--test", recordings / "left", "--robot", "panda"
    )
    error = calibrate(recordings, Path("calibrated"))
    require(error < LARGEST_ERROR, f"the calibrated arm is off by {1e3 * error:.3f} mm")
    record(recordings, Path("recorded"))
    python, seconds = sys.version.split()[0], time.perf_counter() - begin
    print(
        f"Python {python}: mukca {mukca.__version__} off by {1e3 * error:.3f} mm, {seconds:.0f} s"
    )
