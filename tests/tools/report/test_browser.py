"""The report in a real browser: no error, no network, every plot there, the views turn."""

import json
import re
from pathlib import Path

import pytest

from mukca.tools.cli import main

playwright = pytest.importorskip("playwright.sync_api")
expect = playwright.expect
expect.set_options(timeout=300_000)

ARMS = ("kuka_14", "dinova_2")

LOOKS = Path(__file__).with_name("looks.js").read_text()

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def tab(chromium):
    """One for all pages: each program that draws one takes as long to start as a page to load."""
    with chromium.new_page() as tab:
        yield tab


@pytest.fixture
def show(tab):
    """Open a page of a given width; in the end, see that nothing went wrong in it."""
    complaints = []
    requests = []
    listeners = {
        "console": lambda message: complaints.append(message.text),
        "pageerror": lambda error: complaints.append(str(error)),
        "dialog": lambda dialog: complaints.append(dialog.message),
        "request": lambda request: requests.append(request.url),
    }
    for event, listener in listeners.items():
        tab.on(event, listener)

    shown = []

    def show(file, width=1400, *, folded=False):
        shown.append(file)
        tab.set_viewport_size({"width": width, "height": 900})
        tab.goto(file.as_uri())
        if folded:
            return tab
        tab.evaluate("for (const one of document.querySelectorAll('details')) one.open = true")
        expect(tab.locator("canvas:not([data-yaw])")).to_have_count(0)
        return tab

    yield show
    tab.evaluate("0")  # whatever was told before this answer has come as well
    for event, listener in listeners.items():
        tab.remove_listener(event, listener)
    assert complaints == []
    assert requests or not shown  # nothing is shown where the recordings are missing
    assert all(address.startswith(("file://", "data:")) for address in requests)


@pytest.fixture
def report(shared, request):
    """Return the folder with the report of the demo, or of a real arm."""

    def report(name):
        if name == "demo":
            return request.getfixturevalue("demo") / "calibrated"
        data = request.getfixturevalue("recordings") / name
        robot = ("--robot", str(data / "nominal.urdf"))
        words = ["solve", str(data / "front"), "--test", str(data), *robot, "--method", "paper"]

        def make(out):
            main([*words, "--out", str(out)])

        return shared(name, make)

    return report


@pytest.mark.parametrize("name", ["demo", *ARMS])
def test_every_plot_is_there_with_its_sentence(show, report, name):
    figures = json.loads((report(name) / "report.json").read_text())
    for width in (400, 1400):
        page = show(report(name) / "report.html", width)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        for plot in figures["plots"]:
            figure = page.locator(f"figure#{plot['id']}")
            assert figure.locator("figcaption").inner_text() == plot["sentence"]
            box = figure.locator("svg, canvas").first.bounding_box()
            assert box["width"] > 100 and box["height"] > 60
            assert box["x"] >= 0 and box["x"] + box["width"] <= width
        for look in ("cut", "small", "collisions"):
            assert page.evaluate(f"({LOOKS}).{look}()") == [], look


@pytest.mark.parametrize("scene", ["errors", "arm"])
def test_the_views_turn_under_the_mouse_and_obey_their_controls(show, report, scene):
    page = show(report("demo") / "report.html")
    canvases = page.locator(f"canvas[data-scene={scene}]")
    canvas = canvases.first
    canvas.scroll_into_view_if_needed()
    before, yaw = canvas.screenshot(), canvas.get_attribute("data-yaw")
    box = canvas.bounding_box()
    page.mouse.move(box["x"] + 100, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 220, box["y"] + 140, steps=4)
    page.mouse.up()
    expect(canvas).not_to_have_attribute("data-yaw", yaw)
    assert canvas.screenshot() != before
    canvas.dblclick()
    expect(canvas).to_have_attribute("data-yaw", yaw)
    canvas.press("ArrowLeft")
    expect(canvas).not_to_have_attribute("data-yaw", yaw)
    if scene == "errors":
        assert canvases.count() == 2  # which turn together
        expect(canvases.last).to_have_attribute("data-yaw", canvas.get_attribute("data-yaw"))
        count = int(canvas.get_attribute("data-points"))
        page.select_option("[data-control=filter]", "0")
        for cloud in canvases.all():
            expect(cloud).to_have_attribute("data-points", str(count // 3))
    else:
        before = canvas.screenshot()
        page.locator("[data-control=configuration]").fill("7")
        expect(canvas).to_have_attribute("data-configuration", "7")
        moved = canvas.screenshot()
        page.locator("[data-control=overlay]").uncheck()
        page.wait_for_timeout(100)
        assert moved != before and canvas.screenshot() != moved


def test_the_task_can_be_changed(show, report, tmp_path):
    """The page answers for another tolerance in the words in which the report would."""
    folder = report("demo")
    page = show(folder / "report.html")
    figures = json.loads((folder / "report.json").read_text())
    row = next(r for r in figures["placements"] if r["role"] == "left_out")
    names = [r["name"] for r in figures["answers"]["use"]["rows"]]
    largest = 1e3 * row["quantiles"]["calibrated"]["max"]
    for allowed, answer in ((1.001 * largest, "yes"), (0.999 * largest, "mostly"), (0.001, "no")):
        page.locator("[data-control=tolerance]").fill(f"{allowed:.6f}")
        i = figures["placements"].index(row)
        assert page.locator(f"td [data-answer='{i}']").inner_text() == answer
        assert f"{answer}" in page.locator("#use-text").inner_text()
    again = tmp_path / "again"
    main(["report", str(folder / "calibration.json"), "--tolerance-mm", "0.2", "--out", str(again)])
    told = json.loads((again / "report.json").read_text())
    page.locator("[data-control=tolerance]").fill("0.2")
    assert page.locator("#use-text").inner_text() == told["answers"]["use"]["text"]
    captions = {plot["id"]: plot["sentence"] for plot in told["plots"]}
    assert page.locator("#table-map figcaption").inner_text() == captions["table-map"]
    answers = [r["answer"] for r in told["answers"]["use"]["rows"]]
    shown = [page.locator(f"td [data-answer='{i}']").inner_text() for i in range(len(names))]
    assert shown == answers


def test_a_hostile_name_is_shown_as_such(show, document, written):
    name = "<script>alert(1)</script><img src=x onerror=alert(2)>"
    for rows in (document["placements"], document["data"]):
        rows[1]["name"] = f"session/{name}"
    file = written(document)
    main(["report", str(file)])
    page = show(file.parent / "report.html")
    assert name in page.locator(".cards").last.inner_text()
    page.select_option("[data-control=filter]", "1")


@pytest.mark.parametrize("name", ["demo", *ARMS])
def test_it_prints_on_eight_pages_at_most(show, report, name):
    """What is folded stays on the screen."""
    page = show(report(name) / "report.html", folded=True)
    pdf = page.pdf(format="A4")
    assert pdf.startswith(b"%PDF") and len(pdf) > 50_000
    assert 2 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 8
    assert page.locator("details[open]").count() == 0


@pytest.mark.parametrize("name", ["demo", *ARMS])
def test_what_is_not_folded_is_read_in_five_minutes(show, report, name):
    page = show(report(name) / "report.html", 1280, folded=True)
    assert page.evaluate("document.documentElement.scrollHeight") <= 8 * 900
    assert len(page.evaluate("document.body.innerText").split()) <= 1200


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_first_screen_answers(show, report, scheme):
    """Verdict, dots before and after, open points; on a wide screen the contents, too."""
    page = show(report("demo") / "report.html", folded=True)
    page.emulate_media(color_scheme=scheme)
    for width, height in ((1280, 800), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        open_points, dots, contents = (
            page.locator(place).bounding_box()
            for place in ("#open", "#errors-by-placement svg", "nav")
        )
        assert open_points["y"] + open_points["height"] < height and dots["y"] < height
        assert width < 1000 or contents["y"] + contents["height"] < height
    for link in page.locator("nav a, #open a").all():
        assert page.locator(link.get_attribute("href")).count() == 1
    page.emulate_media(color_scheme="light")


def test_without_scripts_the_figures_are_there(chromium, report):
    context = chromium.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto((report("demo") / "report.html").as_uri())
    assert "PASS" in page.locator("#verdict").inner_text()
    assert page.locator("svg.panel").count() > 10
    context.close()


def test_the_comparison_opens_too(show, report, tmp_path):
    file = report("kuka_14") / "calibration.json"
    assert main(["compare", str(file), "--out", str(tmp_path / "c")]) == 0
    page = show(tmp_path / "c/compare.html", 400)
    assert page.locator("figure figcaption").count() == 3
    for width in (400, 1400):
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
