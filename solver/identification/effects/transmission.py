"""Transmission error: gears lead and lag, q' = q + sum over k of a_k sin(k q) + b_k cos(k q)."""

from functools import partial

from ..data import Samples
from .effect import OWN, Array, Effect


def _derivatives(samples: Samples, *, k: int) -> Array:
    import numpy as np

    phases = k * samples.q
    waves = np.sin(phases), np.cos(phases)
    return np.concatenate(waves, axis=1)


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
        stands_for_curves=True,
    )
    for k in (1, 2)
)
