"""Draw docs/images/report.png: the report's first screen, on recordings of a real arm.

    python docs/images/report.py RECORDINGS TRAINED_ON

Needs the test extra, Pillow, and a Chromium on the path.
"""

import io
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

import mukca


def main() -> None:
    everything = mukca.read_placements(sys.argv[1])
    train = [p for p in everything if p.name.endswith(sys.argv[2])]
    robot = mukca.load_robot("panda")
    with tempfile.TemporaryDirectory() as folder:
        calibration = mukca.calibrate(robot, train, test=everything, distance=0.05)
        calibration.save(folder, force=True)
        mukca.write_report(calibration, folder)
        with sync_playwright() as player:
            browser = player.chromium.launch(
                executable_path=shutil.which("chromium"), args=["--no-sandbox"]
            )
            page = browser.new_page(viewport={"width": 1200, "height": 940})
            page.goto((Path(folder) / "report.html").as_uri())
            picture = Image.open(io.BytesIO(page.screenshot()))
            browser.close()
    picture.quantize(256).save(Path(__file__).with_suffix(".png"), optimize=True)


if __name__ == "__main__":
    main()
