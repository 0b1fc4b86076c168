"""``mukca info``, ``convert`` and ``drivers``: what is in recordings, in either form."""

import json

import numpy as np
import pytest
from cases import by_table

import mukca

HEADER = (
    "event,sample,socket,time,stamp,states,position.shoulder,position.rail,"
    "spread.shoulder,spread.rail,effort.shoulder,effort.rail\n"
)
ABOUT = {
    "robot": "arm",
    "joints": ["shoulder", "rail"],
    "units": ["rad", "m"],
    "distance": 0.05,
    "sockets": 2,
    "sessions": [{"driver": "mock:hand", "operator": "Ada"}],
}


@pytest.fixture
def recorded(tmp_path):
    """Three captures, one of them taken back."""
    folder = tmp_path / "data/front"
    folder.mkdir(parents=True)
    rows = [f"capture,{k + 1},{k % 2},1,1,9,{k / 10},0.2,1e-4,1e-6,1,2\n" for k in range(3)]
    (folder / "samples.csv").write_text("".join([HEADER, *rows, "undo,3,0,2,,,,,,,,\n"]))
    (folder / "placement.json").write_text(json.dumps(ABOUT))
    return folder


@pytest.fixture
def output_of(command):
    def output_of(*words):
        status, out, _ = command(*words)
        assert status == 0
        return out

    return output_of


@by_table("words")
def test_info_shows_what_is_there(recorded, output_of, words):
    shown = output_of("info", str(recorded.parent))
    assert [one for one in words if one not in shown] == [], shown
    (placement,) = json.loads(output_of("info", str(recorded), "--json"))["placements"]
    assert placement["samples"] == {"0": 1, "1": 1} and placement["taken_back"] == 1
    assert placement["joints"] == ["shoulder", "rail"] and placement["distance"] == 0.05
    assert placement["lowest"] == [0.0, 0.2] and placement["highest"] == [0.1, 0.2]
    assert placement["metadata"]["robot"] == "arm"


def test_a_table_does_not_say_how_many_states_were_averaged(tmp_path, output_of):
    text = "\n".join(["socket,a,b", *(f"{i % 2},{i / 10},{i / 7}" for i in range(6))])
    (tmp_path / "t.csv").write_text(text)
    words = ("convert", tmp_path / "t.csv", "--to", "samples", "--out")
    output_of(*words, tmp_path / "out")
    (placement,) = mukca.read_placements(tmp_path / "out")
    assert {sample.states for sample in placement.samples} == {None}


def test_info_tells_a_torn_end(recorded, command):
    with (recorded / "samples.csv").open("a") as stream:
        stream.write("capture,4,0")
    status, out, err = command("info", recorded)
    assert status == 0 and "torn off by a crash" in err
    assert "1 in socket 0, 1 in socket 1" in out


def test_info_goes_on_after_an_empty_recording(recorded, output_of):
    """As one that was begun, and finished before the first capture."""
    begun = recorded.parent / "begun"
    begun.mkdir()
    (begun / "samples.csv").write_text(HEADER)
    (begun / "placement.json").write_text(json.dumps(ABOUT))
    shown = output_of("info", str(recorded.parent))
    assert "data/begun: no sample\n  robot      arm\n  distance   50 mm" in shown
    assert "data/front: 1 in socket 0" in shown
    empty, _ = json.loads(output_of("info", str(recorded.parent), "--json"))["placements"]
    assert empty["samples"] == {} and empty["lowest"] is None
    assert empty["joints"] == ["shoulder", "rail"]


@by_table("metadata")
def test_info_bears_any_metadata(recorded, output_of, metadata):
    (recorded / "placement.json").write_text(metadata)
    assert "not recorded" in output_of("info", str(recorded))


def test_a_joint_that_stands_still_made_no_whole_turn(tmp_path, command):
    for socket in (0, 1):
        (tmp_path / f"hole_{socket}.csv").write_text("a,b\n0.1,0.2\n0.1,0.3\n")
    assert command("info", tmp_path)[::2] == (0, "")


def test_a_second_header_amid_a_file_is_no_sample(tmp_path, command):
    header, *rows = "a,b", "0.1,0.2", "0.3,0.4", "0.5,0.6"
    for socket in (0, 1):
        lines = (header, *rows[:2], header, *rows[2:])
        (tmp_path / f"hole_{socket}.csv").write_text("\n".join(lines))
    status, out, _ = command("info", tmp_path, "--json")
    (placement,) = json.loads(out)["placements"]
    assert status == 0 and placement["samples"] == {"0": 3, "1": 3}
    assert (placement["lowest"], placement["highest"]) == ([0.1, 0.2], [0.5, 0.6])


def test_columns_of_another_programs_table_are_named(tmp_path, output_of, refused):
    table, out = tmp_path / "table.csv", tmp_path / "front"
    table.write_text("joint_1;joint_2;x_t;x_dif;y-t;z\n90;-45;1000;1.5;20;0.3\n0;10;1;2;3;4\n")
    words = ["convert", str(table), "--to", "points", "--out", str(out), "--columns"]
    place = ["x=x_t+x_dif [mm]", "y=y-t-x_dif [mm]", "z=z"]
    output_of(*words, "q=joint_1..2 [deg]", *place)
    (one, _) = (placement := mukca.read_placements(out)[0]).samples
    assert placement.joint_names == ("joint_1", "joint_2")
    assert one.position == pytest.approx((np.pi / 2, -np.pi / 4))
    assert one.point == pytest.approx((1.0015, 0.0185, 0.3))
    for wrong, said in (
        (["q=joint_1..3 [deg]", *place], "no column 'joint_3'; there are joint_1,"),
        (["q=joint_1..2 [kg]", *place], "write 'q=joint_1..6 [deg]'"),
        (["q=joint_1..2"], "q is needed, and socket, or x, y and z"),
    ):
        refused(said, *words, *wrong, "--force")


def test_convert_there_and_back(recorded, tmp_path, output_of, command):
    holes, back = tmp_path / "holes", tmp_path / "back"
    status, _, err = command("convert", recorded.parent, "--to", "holes", "--out", holes)
    assert status == 0 and "no place for efforts" in err
    assert np.loadtxt(holes / "front/hole_1.csv", delimiter=",").tolist() == [0.1, 0.2]
    output_of("convert", str(holes / "front"), "--to", "samples", "--out", str(back))
    first, second = mukca.read_placements(recorded, back)
    assert np.array_equal(first.positions, second.positions)
    assert np.array_equal(first.sockets, second.sockets)
    assert second.distance == 0.05
    shown = output_of("info", str(back))
    assert "robot      arm" in shown and "operator Ada" in shown


def test_convert_says_of_no_distance_that_it_was_measured(tmp_path, command):
    """Whoever gave it did not say so; only the default must be told from one that is assumed."""
    (tmp_path / "a").mkdir()
    for socket in (0, 1):
        (tmp_path / f"a/hole_{socket}.csv").write_text("0.1,0.2\n0.3,0.4\n")
    for distance, measured in (("0.0489", None), ("0.05", True)):
        words = ("--to", "samples", "--distance", distance, "--out", tmp_path / "b", "--force")
        command("convert", tmp_path / "a", *words)
        written = json.loads((tmp_path / "b/placement.json").read_text())
        assert written["distance"] == float(distance)
        assert written.get("distance_measured") is measured


@pytest.mark.parametrize("form", ["samples", "holes"])
def test_convert_never_replaces_what_it_reads(recorded, refused, form):
    before = (recorded / "samples.csv").read_bytes()
    for path, out in ((recorded, recorded), (recorded.parent, recorded.parent / ".")):
        words = ("convert", path, "--to", form, "--out", out, "--force")
        refused("is what is read; choose another --out", *words)
    assert (recorded / "samples.csv").read_bytes() == before


def test_convert_never_mixes_or_overwrites(recorded, tmp_path, output_of, refused):
    out = tmp_path / "out"
    words = ["convert", str(recorded), "--out", str(out), "--to"]
    output_of(*words, "holes")
    refused("", *words, "holes")
    output_of(*words, "holes", "--force")
    refused("another recording is there", *words, "samples", "--force")
    refused("", *words, "samples", "--distance", "-1")


@pytest.mark.parametrize("form", ["holes", "samples"])
def test_convert_keeps_nothing_that_was_said_of_another_recording(
    recorded, tmp_path, output_of, refused, form
):
    out = tmp_path / "out"
    output_of("convert", recorded, "--out", out, "--to", form)
    about = {**ABOUT, "payload": 0.5, "distance_measured": True}
    (out / "placement.json").write_text(json.dumps(about))
    (recorded / "placement.json").unlink()
    output_of("convert", recorded, "--out", out, "--to", form, "--force")
    placement = mukca.read_placements(out)[0]
    assert placement.distance is None and placement.payload is None
    (out / "points.csv").write_text("")
    refused(
        "another recording is there", "convert", recorded, "--out", out, "--to", form, "--force"
    )


def test_drivers_are_listed_with_what_some_addresses_need(output_of, answer):
    lines = output_of("drivers").splitlines()
    assert any(line.startswith("mock") for line in lines)
    (kinova,) = [line for line in lines if line.startswith("kinova")]
    assert "ready, with serial; can:// with isotp; " in kinova
    assert kinova.endswith("kortex:// with kortex_api, NOT installed")
    drivers = answer("drivers")["drivers"]
    assert {"name", "arms", "needs", "missing", "optional", "broken", "source"} == set(drivers[0])
