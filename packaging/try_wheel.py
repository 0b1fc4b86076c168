"""Install a wheel with nothing else in an empty environment, and do the main job there.

    python packaging/try_wheel.py dist/mukca-*.whl [PYTHON ...]

For each Python: a new environment, the wheel and what it names, `mukca demo`, `mukca solve` from
two CSV files, and a look into the report. Says what was installed and how much it weighs.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
SHIPPED = re.compile(
    r"mukca/((drivers|recorder|solver|tools)/.*|__init__|__main__)(?<!test)\.(py|urdf|html|css|js|j2)$"
    r"|mukca/solver/robot/shipped/elasticity\.json$|mukca/tools/cli/commands/verbs\.txt$"
    r"|mukca/py\.typed$|mukca-[^/]*\.dist-info/"
)


def look_inside(wheel):
    """Refuse a wheel that holds a test, a page of documentation or an example."""
    names = zipfile.ZipFile(wheel).namelist()
    strange = [name for name in names if not SHIPPED.match(name)]
    assert not strange, strange
    print(f"{wheel.name}: {len(names)} files, {wheel.stat().st_size / 1e3:.0f} kB")


def try_with(python, wheel):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def run(*words):
            environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
            result = subprocess.run(
                [*map(str, words)],
                cwd=folder,
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
            assert result.returncode == 0, (words, result.stdout, result.stderr)
            return result.stdout

        run(python, "-m", "venv", folder / "env")
        inside = folder / "env/bin/python"
        limits = ("--constraint", ROOT / "constraints.txt", "--quiet")
        run(inside, "-m", "pip", "install", *limits, wheel)
        mukca = folder / "env/bin/mukca"
        run(mukca, "demo", "--out", "demo")
        for base in ("front", "left"):
            run(
                mukca, "convert", f"demo/recordings/{base}", "--to", "holes", "--out", f"csv/{base}"
            )
        words = ("solve", "csv/front", "--test", "csv/left", "--robot", "panda", "--distance", 0.05)
        result = json.loads(run(mukca, *words, "--out", "calibrated", "--json"))
        report = Path(folder / "calibrated/report.html").read_text()
        assert "</html>" in report and "Verdict" in report
        error = result["summary"]["test"]["calibrated"]["mean_absolute_error"]
        assert error < 2e-4, error
        version = run(inside, "-c", "import mukca, sys; print(sys.version.split()[0])").strip()
        packages = json.loads(run(inside, "-m", "pip", "list", "--format", "json"))
        size = run("du", "-sm", folder / "env").split()[0]
        print(f"Python {version}: {len(packages)} packages, {size} MB; off by {1e3 * error:.3f} mm")


if __name__ == "__main__":
    wheel, *pythons = sys.argv[1:]
    look_inside(Path(wheel).resolve())
    for python in pythons or [sys.executable]:
        try_with(python, Path(wheel).resolve())
