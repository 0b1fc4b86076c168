"""Draw the pictures of docs/print.md from the STL files that ``mukca print-parts`` writes.

    python docs/images/render_parts.py

Needs the test extra. Rays are cast by trimesh; nothing of the product's own geometry is used but
its files and the JSON that it prints.
"""

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
SAMPLES = 2  # rays along each edge of a pixel

Body = tuple[trimesh.Trimesh, tuple[float, float, float]]


def parts(*options: str) -> dict[str, trimesh.Trimesh]:
    """Return the parts that the command writes, by name."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "mukca", "print-parts", "--out", folder, "--json"]
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
    margin: float = 1.06,
) -> None:
    """Cast parallel rays on bodies from a direction [deg], shade them, and write a PNG."""
    scene = trimesh.util.concatenate([mesh for mesh, _ in bodies])
    colours = np.concatenate([np.tile(c, (len(mesh.faces), 1)) for mesh, c in bodies])
    right, up, towards = camera(azimuth, elevation)
    flat = scene.vertices @ np.column_stack((right, up))
    middle, extent = (flat.min(0) + flat.max(0)) / 2, np.ptp(flat, axis=0)
    width, height = (SAMPLES * edge for edge in size)
    step = max(extent[0] / width, extent[1] / height) * margin
    u = middle[0] + (np.arange(width) - (width - 1) / 2) * step
    v = middle[1] - (np.arange(height) - (height - 1) / 2) * step
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    origins = grid @ np.vstack((right, up)) + 1000 * towards
    faces = scene.ray.intersects_first(origins, np.tile(-towards, (len(origins), 1)))
    image = shade(scene, colours, faces, (right, up, towards)).reshape(height, width, 3)
    normals = np.where(faces[:, None] >= 0, scene.face_normals[faces], 0).reshape(height, width, 3)
    image[creases(normals)] *= 0.55
    small = image.reshape(size[1], SAMPLES, size[0], SAMPLES, 3).mean(axis=(1, 3))
    picture = Image.fromarray((255 * small.clip(0, 1)).astype(np.uint8))
    picture.quantize(64).save(HERE / name, optimize=True)


def camera(azimuth: float, elevation: float) -> tuple[NDArray[np.float64], ...]:
    """Return the directions to the right, up, and towards the viewer."""
    a, e = np.radians((azimuth, elevation))
    towards = np.array((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)))
    right = np.array((-np.sin(a), np.cos(a), 0.0))
    return right, np.cross(towards, right), towards


def shade(
    scene: trimesh.Trimesh,
    colours: NDArray[np.float64],
    faces: NDArray[np.int64],
    axes: tuple[NDArray[np.float64], ...],
) -> NDArray[np.float64]:
    """Return each ray's colour: two lamps on the face that it hits, white where it hits none."""
    right, up, towards = axes
    lamps = ((towards + up - 0.8 * right, 0.55), (towards + 1.2 * right, 0.25))
    light = np.full(len(scene.faces), 0.28)
    for direction, strength in lamps:
        light += strength * (scene.face_normals @ direction / np.linalg.norm(direction)).clip(0)
    return np.where(faces[:, None] >= 0, colours[faces] * light[faces, None], 1.0)


def creases(normals: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return where the surface turns sharply from one ray to the next."""
    marks = np.zeros(normals.shape[:2], dtype=bool)
    marks[:, 1:] |= np.linalg.norm(np.diff(normals, axis=1), axis=2) > 0.35
    marks[1:] |= np.linalg.norm(np.diff(normals, axis=0), axis=2) > 0.35
    return marks


def seated(mesh: trimesh.Trimesh, at: tuple[float, float, float], ball_height: float, tilt: float,
           azimuth: float) -> trimesh.Trimesh:  # fmt: skip
    """Return a ball part turned neck up, its ball at a point, leaning [deg]."""
    turn = trimesh.transformations
    axis = (-np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth)), 0)
    pose = turn.rotation_matrix(np.radians(tilt), axis) @ turn.rotation_matrix(np.pi, (1, 0, 0))
    move = turn.translation_matrix(at) @ pose @ turn.translation_matrix((0, 0, -ball_height))
    return mesh.copy().apply_transform(move)


def main() -> None:
    """Draw all pictures."""
    made = parts()
    base = made["socket-base-2x50mm"]
    long = parts("--mount", "none", "--distance", "0.12")["socket-base-2x120mm"]
    three = parts("--mount", "none", "--sockets", "3")["socket-base-3x50mm"]
    cup = parts("--mount", "iso-50-4-m6", "--bought-ball")["ball-iso-50-4-m6"]
    draw("socket-base.png", [(base, GREY)], -62, 38, (720, 480))
    draw("socket-base-above.png", [(base, GREY)], -90, 89.99, (640, 610))
    draw("socket-base-long.png", [(long, GREY)], -62, 38, (720, 420))
    draw("socket-base-three.png", [(three, GREY)], -62, 42, (640, 520))
    for name, mesh in made.items():
        if name.startswith("ball-"):
            draw(f"{name}.png", [(mesh, ORANGE)], -62, 25, (320, 360))
    draw("ball-bought.png", [(cup, ORANGE)], -62, 35, (320, 300))
    leaning = seated(made["ball-iso-50-4-m6"], (-25, 0, 30), 70, 60, 0)
    draw("tilt.png", [(base, GREY), (leaning, ORANGE)], -90, 12, (720, 400))
    half = trimesh.intersections.slice_mesh_plane(base, (0, 1, 0), (0, 0, 0), cap=True)
    upright = seated(made["ball-franka-hand"], (-25, 0, 30), 39.5, 0, 0)
    draw("section.png", [(half, GREY), (upright, ORANGE)], -90, 8, (720, 520))


if __name__ == "__main__":
    main()
