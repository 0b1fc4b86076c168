"""The files: what other programs read in them."""

import re
import zipfile
from io import BytesIO
from xml.etree import ElementTree

import mesh_checks
import numpy as np
import printed_parts
import pytest
import trimesh
from cases import by_table

from mukca.solver.identification.robot import shipped_robots
from mukca.tools.printables import MOUNTS, PrintableError, bolt_circle, encode, find_mount

pytestmark = pytest.mark.slow


def test_an_stl_file_has_the_length_that_it_announces():
    content = encode("stl", printed_parts.base("default"))
    assert not content.startswith(b"solid")
    assert len(content) == 84 + 50 * int.from_bytes(content[80:84], "little")
    facets = np.frombuffer(
        content[84:], np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")])
    )
    sides = facets["c"].astype(float)
    area = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    large = np.linalg.norm(area, axis=1) > 1e-3
    unit = area[large] / np.linalg.norm(area[large], axis=1, keepdims=True)
    assert facets["n"][large] == pytest.approx(unit, abs=1e-3)


def test_a_3mf_file_has_no_date_that_changes():
    """The same part makes the same file."""
    content = encode("3mf", printed_parts.base("default"))
    assert encode("3mf", printed_parts.base("default")) == content
    with zipfile.ZipFile(BytesIO(content)) as archive:
        assert {entry.date_time[0] for entry in archive.infolist()} == {1980}


@pytest.mark.parametrize("part", ["base", "ball"])
def test_a_3mf_file_holds_the_same_body_in_millimetres(part):
    made = printed_parts.base("three") if part == "base" else printed_parts.ball("franka-hand")
    content = encode("3mf", made, "Ada")
    with zipfile.ZipFile(BytesIO(content)) as archive:
        assert archive.testzip() is None
        model = archive.read("3D/3dmodel.model").decode()
    assert 'unit="millimeter"' in model
    for name, text in (("Title", made.name), ("Designer", "Ada"), ("LicenseTerms", "Apache")):
        assert f'<metadata name="{name}">{text}' in model
    mesh = trimesh.load_mesh(BytesIO(content), file_type="3mf")
    same = mesh_checks.load_stl(encode("stl", made))
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(same.volume, rel=1e-6)
    assert mesh.bounds == pytest.approx(same.bounds, abs=1e-4)


@pytest.mark.parametrize("name", ["franka-hand", "strap", "iso-80-6-m8"])
def test_a_drawing_has_the_dimensions_of_its_part(name):
    made, ball = printed_parts.ball(name), printed_parts.BALLS[name]
    page = ElementTree.fromstring(encode("svg", made))
    told = [text.text for text in page.iter("{http://www.w3.org/2000/svg}text")]
    sizes = [*made.facts["size"]]
    lengths = [1000 * sizes[2], ball.height - ball.mount.origin, *(1000 * v for v in sizes[:2])]
    assert [float(text or "") for text in told[:4]] == pytest.approx(lengths, abs=0.06)
    if ball.mount.holes:
        diameter, words = ball.mount.holes
        (circle,) = page.iter("{http://www.w3.org/2000/svg}circle")
        assert 2 * float(circle.get("r") or "") == diameter
        assert told[4] == words
        told.pop(4)
    assert f"{made.facts['mass']['PLA'] * 1000:.0f} g of PLA" in (told[5] or "")
    assert made.facts["mass"]["PLA"] == pytest.approx(1240 * made.facts["volume"])


@pytest.mark.parametrize("name", ["default", "three"])
def test_the_drawing_of_a_base_has_what_a_caliper_reads(name):
    base = printed_parts.BASES[name]
    page = ElementTree.fromstring(encode("svg", printed_parts.base(name)))
    texts = [text.text for text in page.iter("{http://www.w3.org/2000/svg}text")]
    assert [float(text or "") for text in texts[4:7]] == [base.distance, base.outside, base.inside]
    circles = list(page.iter("{http://www.w3.org/2000/svg}circle"))  # two views of each ball
    assert len(circles) == 2 * base.sockets == 2 * sum("dust hole" in text for text in texts)
    assert {2 * float(circle.get("r") or "") for circle in circles} == {base.ball}
    (xs, ys) = np.transpose([[float(c.get(k) or "") for k in ("cx", "cy")] for c in circles[1::2]])
    centres = np.array(base.centres)
    assert np.allclose(xs - xs[0], (centres - centres[0])[:, 0], atol=0.02)
    assert np.allclose(ys - ys[0], -(centres - centres[0])[:, 1], atol=0.02)
    lines = [line.get("d") or "" for line in page.iter("{http://www.w3.org/2000/svg}path")]
    ends = [re.findall(r"[\d.]+", line) for line in lines if line.count("L") == 1][4:7]
    lengths = [float(x2) - float(x1) for x1, _, x2, _ in ends]
    assert lengths == pytest.approx([base.distance, base.outside, base.inside], abs=0.02)


@by_table("part", "recipe", "hours", "cm3")
def test_a_slicer_says_the_same_time_and_plastic(part, recipe, hours, cm3):
    """The table is of PrusaSlicer 2.5.0 at the settings of docs/print.md."""
    made = (printed_parts.base if recipe == "base" else printed_parts.ball)(part)
    assert made.facts["print_time"] / 3600 == pytest.approx(hours, rel=0.06)
    plastic = made.facts["mass"]["PLA"] / 1240
    assert 1e6 * plastic == pytest.approx(cm3, rel=0.05)
    slender = {"franka-hand", "so101", "interbotix", "robotiq-2f-85"}
    assert made.facts["print"]["brim"] == (0.005 if part in slender else 0.0)


def test_each_shipped_robot_has_a_mount():
    for name in shipped_robots():
        assert find_mount(name) in MOUNTS.values(), name
    assert find_mount("iso-31.5-4-m5") == bolt_circle(31.5, 4, "M5")
    assert find_mount("ISO-9409-1-50-4-M6") is find_mount("iso-50-4-m6")


@pytest.mark.parametrize("part", ["base", "ball"])
def test_a_step_file_holds_the_same_body_exactly(part, tmp_path):
    pytest.importorskip("OCP", reason="STEP is tested where the extra mukca[step] is installed")
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_SOLID

    made = printed_parts.base("default") if part == "base" else printed_parts.ball("iiwa14")
    file = tmp_path / "part.step"
    file.write_bytes(encode("step", made))
    reader = STEPControl_Reader()
    reader.ReadFile(str(file))
    reader.TransferRoots()
    shape = reader.OneShape()
    assert shape.ShapeType() == TopAbs_SOLID
    assert BRepCheck_Analyzer(shape).IsValid()
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    assert properties.Mass() == pytest.approx(made.facts["volume"] * 1e9, rel=1e-3)
    assert b"SPHERICAL_SURFACE" in file.read_bytes()


def test_step_without_its_package_is_one_line(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "OCP", None)
    with pytest.raises(PrintableError, match=r"pip install 'mukca\[step\]'"):
        encode("step", printed_parts.ball("franka-hand"))
