"""Sentences of causes by their parameters alone."""

import pytest

from mukca.solver.diagnostics import CAUSES

SOCKET = next(cause for cause in CAUSES if cause.name == "socket")
RUN = {"sample": 8, "last": 11, "number": 9, "last_number": 12, "place": 3, "last_place": 6}
RUN |= {"samples": 4, "socket": 0, "other": 1, "of": "", "size": 0.05}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, "samples 9 to 12 lie in socket 1, 50.0 mm from the others"),
        ({"number": 0}, "samples 3 to 6 of socket 0 lie in socket 1, 50.0 mm from the others"),
        ({"samples": 3}, "3 samples, the first sample 9, lie in socket 1, 50.0 mm from the others"),
        ({"samples": 1, "of": "left"}, "sample 9 lies in socket 1 of left"),
    ],
)
def test_samples_in_another_socket_are_a_run_or_counted(changes, words):
    assert SOCKET.text(RUN | changes) == words
