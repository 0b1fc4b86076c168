"""Places of several robots, and the frames in which they were measured."""

from mukca.solver.bases.places import view_of_frame
from mukca.solver.identification.data import Places


def test_the_corners_of_each_frame_are_places_of_its_own_after_the_sockets():
    labels = ("front", 0), ("front", 1)
    places = Places(labels=labels, known=(), frames=("table", "tracker"))
    numbers = [view_of_frame(places, frame, 0).seen.numbers.tolist() for frame in (0, 1)]
    assert numbers == [[2, 3, 4], [5, 6, 7]]
