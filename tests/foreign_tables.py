"""Tables of one arm's joints as many programs write them, by the name of the look."""

import io
import math
import zipfile

import numpy as np

import mukca

UR = mukca.load_robot("ur5e").joint_names
Q = np.random.default_rng(3).uniform(-2, 2, (5, 6)).round(6)
SHUFFLED = [2, 1, 0, 5, 3, 4]
MORE = 0.25
"""Every other number beside the joints."""


def text_of(header, rows, separator=",", point="."):
    """Lines of cells; numbers as they are written, words as they are."""
    cells = [
        [c if isinstance(c, str) else repr(float(c)).replace(".", point) for c in r] for r in rows
    ]
    lines = [separator.join(header)] if header else []
    return "\n".join([*lines, *(separator.join(row) for row in cells)]) + "\n"


def named(form, order=SHUFFLED, scale=1.0):
    """Joints in the drivers' order, each called in a form of its name."""
    return text_of([form.format(UR[k]) for k in order], (scale * Q[:, order]).tolist())


def beside(name, values, first=True):
    """A column that nobody needs, before the joints or behind them."""
    rows = [[v, *q] if first else [*q, v] for v, q in zip(values, Q.tolist(), strict=True)]
    return text_of([name, *UR] if first else [*UR, name], rows)


def ros2_echo():
    rows = [["17", f"{i}00", "base", *(UR[k] for k in SHUFFLED), *Q[i, SHUFFLED]] for i in range(5)]
    return text_of([], [[*row, *[MORE] * 6] for row in rows])


def rostopic():
    fields = [f"field.{kind}{k}" for kind in ("name", "position", "velocity") for k in range(6)]
    head = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id", *fields]
    rows = [
        ["17", "3", "17", "", *(UR[k] for k in SHUFFLED), *Q[i, SHUFFLED], *[MORE] * 6]
        for i in range(5)
    ]
    return text_of(head, rows)


def plot_juggler():
    head = [
        "__time",
        *(f"/joint_states/{UR[k]}/{kind}" for kind in ("position", "velocity") for k in SHUFFLED),
    ]
    return text_of(head, [[17 + i, *Q[i, SHUFFLED], *[MORE] * 6] for i in range(5)])


def universal_robots(separator):
    kinds = ("target_q", "actual_q", "target_qd", "actual_qd", "actual_current")
    head = ["timestamp", *(f"{kind}_{k}" for kind in kinds for k in range(6))]
    rows = [[17 + i, *Q[i] + 0.01, *Q[i], *[MORE] * 18] for i in range(5)]
    return text_of(head, rows, separator)


PARTS = {
    "xl/workbook.xml": '<workbook xmlns="{main}" xmlns:r="{office}/relationships"><sheets>'
    '<sheet name="Empty" sheetId="2" r:id="rId2"/><sheet name="Cell 3" sheetId="1" r:id="rId1"/>'
    "</sheets></workbook>",
    "xl/_rels/workbook.xml.rels": '<Relationships xmlns="{package}/relationships">'
    '<Relationship Id="rId1" Type="t" Target="worksheets/sheet1.xml"/>'
    '<Relationship Id="rId2" Type="t" Target="/xl/worksheets/sheet2.xml"/></Relationships>',
    "xl/worksheets/sheet2.xml": '<worksheet xmlns="{main}"><sheetData/></worksheet>',
    "xl/worksheets/sheet1.xml": '<worksheet xmlns="{main}"><sheetData>{rows}</sheetData>'
    "</worksheet>",
    "xl/sharedStrings.xml": '<sst xmlns="{main}">{words}</sst>',
}
"""Parts of a workbook as spreadsheets save it; the first sheet is empty."""
SPACES = {
    "main": "http://schemas.openxmlformats.org/spreadsheetml/2006/main",
    "office": "http://schemas.openxmlformats.org/officeDocument/2006",
    "package": "http://schemas.openxmlformats.org/package/2006",
}


def workbook(text, first_row=3, **parts):
    """XLSX of a table between commas, below some empty rows."""
    names, *lines = (line.split(",") for line in text.splitlines())
    cells = [[f't="s"><v>{i}' for i in range(len(names))]]
    cells += [[f"><v>{number}" for number in line] for line in lines]
    rows = ""
    for i, row in enumerate(cells, first_row):
        columns = (f'<c r="{chr(65 + k)}{i}" {cell}</v></c>' for k, cell in enumerate(row))
        rows += f'<row r="{i}">{"".join(columns)}</row>'
    words = "".join(f"<si><t>{name}</t></si>" for name in names)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, part in (PARTS | parts).items():
            archive.writestr(name, part.format(rows=rows, words=words, **SPACES))
    return stream.getvalue()


LOOKS = {
    "plain": text_of([], Q.tolist()),
    "names": named("{}"),
    "semicolons and decimal commas": text_of(UR, Q.tolist(), ";", ","),
    "tabs": text_of(UR, Q.tolist(), "\t"),
    "tabs and decimal commas": text_of(UR, Q.tolist(), "\t", ","),
    "blanks": text_of(UR, Q.tolist(), "  "),
    "byte order mark": "\ufeff" + named("{}"),
    "quoted": named('"{}"'),
    "quoted behind blanks": text_of([f'"{n}"' for n in UR], Q.tolist(), ", "),
    "comments": "# by hand\n" + named("{}") + "# the end\n",
    "numpy's header": "# " + named("{}"),
    "spreadsheet": "sep=;\n" + text_of(UR, Q.tolist(), ";", ","),
    "trailing separators": named("{}").replace("\n", ",\n"),
    "trailing separators below the header": named("{}")
    .replace("\n", ",\n")
    .replace(",\n", "\n", 1),
    "capitals": named("{}").upper().replace("E-", "e-"),
    "titles": named("{}").replace("_", " ").title(),
    "words": named("{}").replace("_joint", ""),
    "prefix": named("left_{}"),
    "name space": named("/ns/arm/{}"),
    "serial number": named("ur5e-20235501234_{}"),
    "lerobot": named("{}.pos").replace("_joint", ""),
    "recorder": named("position.{}"),
    "motors": named("{}.present_position"),
    "unit in brackets": named("{} [rad]"),
    "degrees in brackets": named("{} [deg]", scale=180 / math.pi),
    "degrees in parentheses": named("{} (deg)", scale=180 / math.pi),
    "degrees without a blank": named("{}[°]", scale=180 / math.pi),
    "degrees at the end": named("{}_deg", scale=180 / math.pi),
    "degrees in capitals": named("{}_DEG", scale=180 / math.pi),
    "degrees and .pos": named("{}.pos [deg]", scale=180 / math.pi),
    "lists": "".join(f"{row}\n" for row in Q.tolist()),
    "tuples": "".join(f"({str(row)[1:-1]}),\n" for row in Q.tolist()),
    "numbers of NumPy 2": text_of(UR, [[f"np.float64({x!r})" for x in row] for row in Q.tolist()]),
    "unit row": named("{}").replace("\n", "\nrad,rad,rad,rad,rad,rad\n", 1),
    "unit row in degrees": named("{}", scale=180 / math.pi).replace("\n", f"\n{'[deg],' * 6}\n", 1),
    "German degrees": named("{} [Grad]", scale=180 / math.pi),
    "degrees behind a stroke": named("{} / °", scale=180 / math.pi),
    "a title": "Cell 3, my arm\n" + named("{}"),
    "a title that a spreadsheet pads": "my arm,,,,,\n" + named("{}"),
    "groups, names, units": "Joints,,,,,\n"
    + text_of([f"J{k}" for k in range(1, 7)], (180 / math.pi * Q).tolist()).replace(
        "\n", f"\n{','.join(['deg'] * 6)}\n", 1
    ),
    "remarks row": named("{}").replace("\n", "\nfirst,b,c,d,e,f\n", 1),
    "comments behind strokes": "// by hand\n" + named("{}").replace("\n", " // noted\n"),
    "blanks in names without a comma": text_of([f"Axis {k}" for k in range(1, 7)], Q.tolist(), " "),
    "pendant of Universal Robots": text_of(
        [f"{n} [°]" for n in ("Base", "Shoulder", "Elbow", "Wrist 1", "Wrist 2", "Wrist 3")],
        (180 / math.pi * Q).tolist(),
    ),
    "pendant of Yaskawa": text_of(list("SLURBT"), Q.tolist()),
    "q1": text_of([f"q{k}" for k in range(1, 7)], Q.tolist()),
    "q_0": text_of([f"q_{k}" for k in range(6)], Q.tolist()),
    "J1": text_of([f"J{k}" for k in range(1, 7)], Q.tolist()),
    "joint_1 in another order": text_of(
        [f"joint_{k + 1}" for k in SHUFFLED], Q[:, SHUFFLED].tolist()
    ),
    "position[0]": text_of([f"/joint_states/position[{k}]" for k in range(6)], Q.tolist()),
    "axes with a gripper": text_of(
        ["gripper", *(f"A{k} [rad]" for k in range(1, 7))], [[MORE, *q] for q in Q]
    ),
    "0 to 5": text_of([str(k) for k in range(6)], Q.tolist()),
    "1 to 6": text_of([str(k) for k in range(1, 7)], Q.tolist()),
    "pandas without names": text_of(
        ["", *map(str, range(6))], [[str(i), *q] for i, q in enumerate(Q)]
    ),
    "pandas": beside("", [str(i) for i in range(5)]),
    "pandas read again": beside("Unnamed: 0", [str(i) for i in range(5)]),
    "time": beside("time", range(5)),
    "dates": beside("timestamp", [f"2026-05-12T10:0{i}:00.123Z" for i in range(5)]),
    "image names": beside("image", [f"img_{i}.png" for i in range(5)]),
    "image names without a header": text_of([], [[f"{i}.png", *q] for i, q in enumerate(Q)]),
    "notes": beside("note", ["", "ok", "", "", "bumped"], first=False),
    "nothing": beside("frame_id", [""] * 5),
    "a gripper": beside("gripper [%]", [50.0] * 5),
    "a gripper that says nothing at times": beside("gripper", ["", "nan", "1.0", "", "2.0"]),
    "two columns of one name": text_of([*UR, "f", "f"], [[*q, MORE, MORE] for q in Q]),
    "velocities": text_of([*UR, *(f"{n}_velocity" for n in UR)], [[*q, *[MORE] * 6] for q in Q]),
    "commands": text_of(
        [f"{p}{n}" for p in ("target_", "actual_") for n in UR], [[*q + 0.01, *q] for q in Q]
    ),
    "commands behind the names": text_of(
        [f"{n}_{kind}" for kind in ("cmd", "fbk") for n in UR], [[*q + 0.01, *q] for q in Q]
    ),
    "commands in German": text_of(
        [f"Achse {k} {kind}" for kind in ("Soll", "Ist") for k in range(1, 7)],
        [[*q + 0.01, *q] for q in Q],
    ),
    "ros2 topic echo --csv": ros2_echo(),
    "rostopic echo -p": rostopic(),
    "PlotJuggler": plot_juggler(),
    "ur_rtde": universal_robots(","),
    "RTDE": universal_robots(" "),
}
BYTES = {
    "CRLF": named("{}").replace("\n", "\r\n").encode(),
    "CR": named("{}").replace("\n", "\r").encode(),
    "UTF-16": named("{}").encode("utf-16"),
    "Latin-1": named("{} [°]", scale=180 / math.pi).encode("latin-1"),
    "XLSX": workbook(named("{} [deg]", scale=180 / math.pi)),
    "no last line break": named("{}").rstrip("\n").encode(),
}
BYTES |= {look: text.encode() for look, text in LOOKS.items()}

PROGRAMS = {
    "ros2 topic echo --csv": "`ros2 topic echo --csv /joint_states`",
    "rostopic echo -p": "`rostopic echo -p /joint_states`",
    "PlotJuggler": "PlotJuggler, CSV export",
    "pandas": "pandas, `to_csv(FILE)`",
    "0 to 5": "pandas, without names of columns",
    "RTDE": "RTDE client of Universal Robots",
    "ur_rtde": "ur_rtde, `startFileRecording`",
    "lerobot": "lerobot, observations",
    "motors": "motors, their registers",
    "recorder": "`mukca record`",
    "name space": "a name space before the names",
    "degrees in parentheses": "degrees in the header",
    "unit row in degrees": "units below the header",
    "semicolons and decimal commas": "a spreadsheet of a country with decimal commas",
    "numpy's header": "numpy, `savetxt(FILE, header=..)`",
    "dates": "times as text",
    "image names": "names of images",
    "German degrees": "degrees in German",
    "pendant of Universal Robots": "names on a pendant of Universal Robots, which is said",
    "pendant of Yaskawa": "names on a pendant of Yaskawa; the T is no time",
    "groups, names, units": "groups of columns above their names",
    "comments behind strokes": "notes behind two strokes",
    "q1": "numbers of joints; taken in order, which is said",
    "lists": "lists as Python prints them; taken in order",
    "plain": "no header; taken in order",
}
"""Looks that the documentation shows, and what writes them."""
WIDTH = 60
"""Letters of a line that the documentation shows."""


def shown(line):
    return f"`{line[:WIDTH]}{' ..' if len(line) > WIDTH else ''}`".replace("|", "\\|")


def page():
    """Return the table of the documentation, a program in each row."""
    rows = ["| written by | first line, and one below |", "|---|---|"]
    for look, program in PROGRAMS.items():
        first, *_, last = LOOKS[look].splitlines()
        header = (
            "" if look in ("lists", "plain", "ros2 topic echo --csv") else f"{shown(first)}<br>"
        )
        rows.append(f"| {program} | {header}{shown(last)} |")
    return "\n".join(rows) + "\n"
