"""The default method (``--method auto``): geometry, elasticity and transmission error.

docs/model.md explains its four words, prior, posterior, evidence and harmonic. Reading order:
:mod:`.deflection` and :mod:`.extended_model` (what is unknown), :mod:`.priors`, :mod:`.noise` and
:mod:`.objective` (what is minimised), :mod:`.normal_equations`, :mod:`.states`,
:mod:`.hyperparameters` and :mod:`.estimation` (how), :mod:`.laplace` and :mod:`.posterior` (the
result), :mod:`.selection` and :mod:`.averaging` (which extensions to keep, and how much of each).
"""
