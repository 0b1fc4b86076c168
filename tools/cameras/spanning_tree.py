"""Prim's spanning tree, along which views of one session are compared with their neighbours."""

import numpy as np


def spanning_tree(
    distances: np.ndarray,
    root: int,
    groups: np.ndarray,
) -> list[tuple[int, int]]:
    """Return each node that is added, nearest first, and the node of the tree it is nearest to.

    Args:
        distances: Between every two nodes, shape (K, K).
        root: The node to begin with.
        groups: Number of each node's group, shape (K,). The tree has one node of each.
    """
    nearest = distances[root].copy()
    neighbour = np.full(len(groups), root)
    remaining = groups != groups[root]
    edges: list[tuple[int, int]] = []
    while remaining.any():
        node = int(np.argmin(np.where(remaining, nearest, np.inf)))
        edges.append((node, int(neighbour[node])))
        remaining &= groups != groups[node]
        nearer = distances[node] < nearest
        nearest[nearer] = distances[node, nearer]
        neighbour[nearer] = node
    return edges
