"""What can be asked of a printed part's mesh, with trimesh and rays: nothing of the product."""

from io import BytesIO

import numpy as np
import trimesh

TOUCH = 1e-3  # what is less deep than that touches, and does not cross [mm]


def load_stl(content):
    """Read an STL file as a slicer does: triangles, whose equal corners are then joined."""
    return trimesh.load_mesh(BytesIO(content), file_type="stl")


def crossings(segments, mesh):
    """Return which segments, shape (n, 2, 3), cross which faces, both ends deeper than TOUCH."""
    lengths = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    kept = np.flatnonzero(lengths > 2 * TOUCH)
    starts, ways = segments[kept, 0], (segments[kept, 1] - segments[kept, 0])
    ways /= lengths[kept, None]
    # A face so deep in a segment is as far from both its ends; most hit nothing between these.
    hits = _hit_before(lengths[kept] - 2 * TOUCH, starts + TOUCH * ways, ways, mesh)
    kept, starts, ways = kept[hits], starts[hits], ways[hits]
    _, rays, faces = mesh.ray.intersects_location(starts, ways, multiple_hits=True)
    corners, normals = mesh.triangles[faces, 0], mesh.face_normals[faces]
    first, second = (
        ((segments[kept[rays], end] - corners) * normals).sum(axis=1) for end in (0, 1)
    )
    deep = (first * second < 0) & (np.minimum(abs(first), abs(second)) > TOUCH)
    return kept[rays[deep]], faces[deep]


def _hit_before(lengths, starts, ways, mesh):
    """Return the rays that may hit a face before they end, by Embree where it is installed.

    Trimesh asks it for rays without an end: six times as long.
    """
    scene = getattr(mesh.ray, "_scene", None)
    if scene is None:
        return np.arange(len(lengths))
    ends = (lengths * scene.scale).astype(np.float32)
    return np.flatnonzero(scene.run(starts, ways, dists=ends) >= 0)


def self_crossings(mesh):
    """Count the edges that pierce a face which they do not touch.

    Two triangles of a mesh that share no corner intersect exactly if an edge of one pierces the
    other (or they lie in one plane, where a closed surface has no room for a second layer).
    """
    edges, faces = crossings(mesh.vertices[mesh.edges_unique], mesh)
    own = (mesh.faces[faces][:, :, None] == mesh.edges_unique[edges][:, None, :]).any(axis=(1, 2))
    return int((~own).sum())


def collide(moved, fixed, pose=None):
    """Tell whether two closed surfaces intersect, or one holds the other.

    Args:
        moved: One of them, in its own frame.
        fixed: The other.
        pose: From the frame of the moved one to that of the fixed one, shape (4, 4).
    """
    pose = np.eye(4) if pose is None else pose
    back = np.linalg.inv(pose)
    return (
        len(crossings(_edges_near(moved, fixed, pose), fixed)[0]) > 0
        or len(crossings(_edges_near(fixed, moved, back), moved)[0]) > 0
        or bool(fixed.contains(_moved(moved.vertices[:1], pose))[0])
        or bool(moved.contains(_moved(fixed.vertices[:1], back))[0])
    )


def _moved(points, pose):
    return points @ pose[:3, :3].T + pose[:3, 3]


def _edges_near(mesh, other, pose):
    """Return the edges, moved by a pose, that do not lie beyond one side of the other's box."""
    points = _moved(mesh.vertices, pose)
    low, high = other.bounds
    beyond = np.packbits(np.hstack([points < low, points > high]), axis=1)[:, 0]
    edges = np.asarray(mesh.edges_unique)
    return points[edges[beyond[edges[:, 0]] & beyond[edges[:, 1]] == 0]]


def thinnest_wall(mesh, samples=20000):
    """Return the least distance through the material to an opposite face.

    From points all over the surface, straight inwards; faces that lean more than 45 degrees to
    each other are no wall but an edge.
    """
    points, faces = trimesh.sample.sample_surface(mesh, samples, seed=1)
    normals = mesh.face_normals[faces]
    hits, rays, hit = mesh.ray.intersects_location(
        points - 1e-3 * normals, -normals, multiple_hits=False
    )
    opposite = (normals[rays] * mesh.face_normals[hit]).sum(axis=1) < -np.cos(np.pi / 4)
    return float(np.linalg.norm(hits - points[rays], axis=1)[opposite].min())


def overhanging(mesh, degrees=45.0):
    """Return the faces that look down and lean farther from the vertical, but for the bed's."""
    looks_down = mesh.face_normals[:, 2] < -np.sin(np.radians(degrees)) - 1e-3
    lifted = mesh.triangles[:, :, 2].max(axis=1) > 0.01
    return np.flatnonzero(looks_down & lifted & (mesh.area_faces > 1e-6))


def height_at(mesh, points, above=100.0):
    """Return the height of a part's top below a height at points, 0 where there is nothing."""
    origins = np.column_stack((points, np.full(len(points), above)))
    down = np.tile((0.0, 0.0, -1.0), (len(points), 1))
    hits, rays, _ = mesh.ray.intersects_location(origins, down, multiple_hits=False)
    heights = np.zeros(len(points))
    heights[rays] = hits[:, 2]
    return heights


def fit_sphere(points):
    """Return centre and radius of the sphere through points, by linear least squares."""
    system = np.column_stack((2 * points, np.ones(len(points))))
    solution, *_ = np.linalg.lstsq(system, (points**2).sum(axis=1), rcond=None)
    return solution[:3], float(np.sqrt(solution[3] + (solution[:3] ** 2).sum()))
