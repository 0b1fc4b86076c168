"""Samples in sockets as the task of a fit."""

import mukca
from mukca.solver.identification.data import measure
from mukca.solver.partial.prior import prior_of
from mukca.solver.partial.sockets import socket_task


def test_of_two_placements_with_one_name_each_has_its_own_distance(simulated):
    """As in memory, where no folder tells them apart."""
    since = simulated.read({3: 5e-3})
    q, sockets, names = since.positions, since.sockets, since.joint_names
    far = mukca.Placement.of_arrays("since", q, sockets, names, distance=0.06)
    prior = prior_of(simulated.calibration)
    data = [measure(one, prior.robot) for one in (since, far)]
    assert socket_task(prior, data).distances == [(0, 1, 0.05), (2, 3, 0.06)]
