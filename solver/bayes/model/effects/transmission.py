"""Transmission error: gears lead and lag, q' = q + sum over k of a_k sin(k q) + b_k cos(k q)."""

from functools import partial

from .effect import OWN, Array, Effect


def _derivatives(q: Array, moments: Array, *, k: int) -> Array:
    import numpy as np

    del moments
    return np.concatenate([np.sin(k * q), np.cos(k * q)], axis=1)


HARMONICS = tuple(
    Effect(
        name=f"harmonic_{k}",
        extension="transmission",
        unit="rad",
        axes={f"sin{k}": OWN, f"cos{k}": OWN},
        derivatives=partial(_derivatives, k=k),
        # makers of harmonic drives state one arc minute from peak to peak: an amplitude of
        # 0.15 mrad, shared by a sine and a cosine
        typical_shift=1e-4 * 0.5**0.5,
    )
    for k in (1, 2)
)
