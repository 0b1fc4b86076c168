"""Draw the pictures of docs/print.md from the STL files that ``mukca print-parts`` writes.

    python docs/images/render_parts.py

Needs the test extra. Rays are cast by trimesh; nothing of the product's own geometry is used but
its files and the JSON that it prints.
"""

import itertools
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image

HERE = Path(__file__).parent
GREY, ORANGE, BLUE = (0.80, 0.81, 0.83), (0.93, 0.55, 0.20), (0.35, 0.55, 0.80)
DARK, SKIN = (0.45, 0.48, 0.52), (0.94, 0.78, 0.66)
SAMPLES = 2  # rays along each edge of a pixel

Body = tuple[trimesh.Trimesh, tuple[float, float, float]]


def parts(*options: str) -> dict[str, trimesh.Trimesh]:
    """Return the parts that the command writes, by name."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            sys.executable,
            "-m",
            "mukca",
            "print-parts",
            "--out",
            folder,
            "--json",
        ]
        done = subprocess.run([*command, *options], check=True, capture_output=True)
        return {
            part["name"]: trimesh.load_mesh(Path(folder) / f"{part['name']}.stl")
            for part in json.loads(done.stdout)["parts"]
        }


def draw(
    name: str,
    bodies: list[Body],
    azimuth: float,
    elevation: float,
    size: tuple[int, int],
) -> None:
    """Cast parallel rays on bodies from a direction [deg], shade them, and write a PNG."""
    scene = trimesh.util.concatenate([mesh for mesh, _ in bodies])
    colours = np.concatenate([np.tile(c, (len(mesh.faces), 1)) for mesh, c in bodies])
    axes = camera(azimuth, elevation)
    origins, step = rays(scene, axes, size)
    ways = np.tile(-axes[2], (len(origins), 1))
    faces = scene.ray.intersects_first(origins, ways)
    image = np.where(
        faces[:, None] >= 0, colours[faces] * lit(scene, axes)[faces, None], 1.0
    )
    image[edges(scene, origins, ways, faces, step, size)] *= 0.45
    small = image.reshape(size[1], SAMPLES, size[0], SAMPLES, 3).mean(axis=(1, 3))
    picture = Image.fromarray((255 * small.clip(0, 1)).astype(np.uint8))
    picture.quantize(64).save(HERE / name, optimize=True)


def rays(
    scene: trimesh.Trimesh, axes: tuple[NDArray[np.float64], ...], size: tuple[int, int]
) -> tuple[NDArray[np.float64], float]:
    """Return where the rays start, row by row, so that all is seen; and how far they are apart."""
    right, up, towards = axes
    flat = scene.vertices @ np.column_stack((right, up))
    middle, extent = (flat.min(0) + flat.max(0)) / 2, np.ptp(flat, axis=0)
    width, height = (SAMPLES * edge for edge in size)
    step = 1.06 * max(extent[0] / width, extent[1] / height)
    u = middle[0] + (np.arange(width) - (width - 1) / 2) * step
    v = middle[1] - (np.arange(height) - (height - 1) / 2) * step
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    return grid @ np.vstack((right, up)) + 1000 * towards, step


def camera(azimuth: float, elevation: float) -> tuple[NDArray[np.float64], ...]:
    """Return the directions to the right, up, and towards the viewer."""
    a, e = np.radians((azimuth, elevation))
    towards = np.array((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)))
    right = np.array((-np.sin(a), np.cos(a), 0.0))
    return right, np.cross(towards, right), towards


def lit(
    scene: trimesh.Trimesh, axes: tuple[NDArray[np.float64], ...]
) -> NDArray[np.float64]:
    """Return how much light of two lamps falls on each face."""
    right, up, towards = axes
    lamps = ((towards + up - 0.8 * right, 0.55), (towards + 1.2 * right, 0.25))
    light = np.full(len(scene.faces), 0.28)
    for direction, strength in lamps:
        light += strength * (
            scene.face_normals @ direction / np.linalg.norm(direction)
        ).clip(0)
    return light


def edges(
    scene: trimesh.Trimesh,
    origins: NDArray[np.float64],
    ways: NDArray[np.float64],
    faces: NDArray[np.int64],
    step: float,
    size: tuple[int, int],
) -> NDArray[np.bool_]:
    """Return the rays at which the surface turns sharply or steps back from its neighbour."""
    shape = (SAMPLES * size[1], SAMPLES * size[0])
    normals = np.where(faces[:, None] >= 0, scene.face_normals[faces], 0).reshape(
        *shape, 3
    )
    above = (scene.triangles[faces, 0] - origins) * scene.face_normals[faces]
    slope = (ways * scene.face_normals[faces]).sum(axis=1)
    depth = above.sum(axis=1) / np.where(abs(slope) > 1e-6, slope, 1e-6)
    depth = np.where(faces >= 0, depth, 1e4).reshape(shape)
    marks = np.zeros(shape, dtype=bool)
    for axis, inner in ((1, np.s_[:, 1:]), (0, np.s_[1:])):
        turned = np.linalg.norm(np.diff(normals, axis=axis), axis=2) > 0.35
        marks[inner] |= turned | (abs(np.diff(depth, axis=axis)) > 6 * step + 0.3)
    return marks.ravel()


def seated(mesh: trimesh.Trimesh, at: tuple[float, float, float], ball_height: float, tilt: float,
           azimuth: float) -> trimesh.Trimesh:  # fmt: skip
    """Return a ball part turned neck up, its ball at a point, leaning [deg]."""
    turn = trimesh.transformations
    axis = (-np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth)), 0)
    pose = turn.rotation_matrix(np.radians(tilt), axis) @ turn.rotation_matrix(
        np.pi, (1, 0, 0)
    )
    move = (
        turn.translation_matrix(at)
        @ pose
        @ turn.translation_matrix((0, 0, -ball_height))
    )
    return mesh.copy().apply_transform(move)


def jaws(places: tuple[float, float], inwards: bool) -> list[Body]:
    """Return two jaws of a caliper, laid flat around or between the waists at places along x."""
    bodies: list[Body] = []
    for x, side in zip(places, (-1, 1), strict=True):
        jaw = trimesh.creation.box((4, 34, 4))
        jaw.apply_translation((x + (-side if inwards else side) * 2, -8, 13.5))
        bodies.append((jaw, BLUE))
    return bodies


def bar(
    start: tuple[float, ...], end: tuple[float, ...], radius: float
) -> trimesh.Trimesh:
    """Return a round bar between two points."""
    along = np.subtract(end, start)
    mesh = trimesh.creation.capsule(
        height=np.linalg.norm(along), radius=radius, count=[24, 24]
    )
    mesh.apply_transform(trimesh.geometry.align_vectors((0, 0, 1), along))
    return mesh.apply_translation(start)


def hand(radius: float) -> trimesh.Trimesh:
    """Return a hand round a cylinder along z: four fingers, a thumb, the palm and the forearm."""
    around = radius + 8
    fingers = [(z, (-35, 25, 75, 115)) for z in (-27, -9, 9, 27)]
    bones: list[trimesh.Trimesh] = []
    for z, angles in [*fingers, (-5, (-20, -60, -105))]:
        turn = np.radians(angles)
        knuckles = [(around * np.cos(t), around * np.sin(t), z) for t in turn]
        bones += [bar(a, b, 9) for a, b in itertools.pairwise(knuckles)]
    bones += [
        bar((around, -4, z), (around + 40, -22, 0.6 * z - 6), 12)
        for z in (-24, -8, 8, 24)
    ]
    bones.append(bar((around + 44, -24, -6), (around + 150, -70, -40), 23))
    return trimesh.util.concatenate(bones)


def main() -> None:
    """Draw all pictures."""
    made = parts()
    base = made["socket-base-2x100mm"]
    long = parts("--mount", "none", "--distance", "0.15")["socket-base-2x150mm"]
    three = parts("--mount", "none", "--sockets", "3")["socket-base-3x100mm"]
    cup = parts("--mount", "iso-50-4-m6", "--bought-ball")["ball-iso-50-4-m6"]
    draw("socket-base.png", [(base, GREY)], -75, 50, (640, 460))
    draw("socket-base-long.png", [(long, GREY)], -75, 50, (640, 340))
    draw("socket-base-three.png", [(three, GREY)], -75, 50, (520, 460))
    around, between = jaws((-62, 62), False), jaws((-38, 38), True)
    draw("caliper-outside.png", [(base, GREY), *around], -75, 45, (400, 320))
    draw("caliper-inside.png", [(base, GREY), *between], -75, 45, (400, 320))
    for name, mesh in made.items():
        if name.startswith("ball-"):
            draw(f"{name}.png", [(mesh, ORANGE)], -80, 30, (300, 340))
    draw("ball-bought.png", [(cup, ORANGE)], -80, 40, (300, 300))
    leaning = seated(made["ball-iso-50-4-m6"], (-50, 0, 30), 70, 60, 0)
    draw("tilt.png", [(base, GREY), (leaning, ORANGE)], -90, 12, (640, 380))
    wrist = trimesh.creation.cylinder(radius=34, height=90, sections=64)
    held = [(made["ball-iso-50-4-m6"], ORANGE)]
    held += [
        (m.apply_translation((0, 0, -45)), c)
        for m, c in ((wrist, DARK), (hand(34), SKIN))
    ]
    lean = [(seated(mesh, (-50, 0, 30), 70, 28, 200), colour) for mesh, colour in held]
    draw("by-hand.png", [(base, GREY), *lean], -70, 22, (640, 500))
    half = trimesh.intersections.slice_mesh_plane(
        base, (-1, 0, 0), (-50, 0, 0), cap=True
    )
    upright = seated(made["ball-franka-hand"], (-50, 0, 30), 39.5, 0, 0)
    draw("section.png", [(half, GREY), (upright, ORANGE)], 0, 0.01, (560, 480))


if __name__ == "__main__":
    main()
