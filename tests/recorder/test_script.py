"""Key scripts: what a word means, and when its time has come."""

import os

import pytest
from cases import by_table

from mukca import MukcaError
from mukca.recorder.terminal import Script

PATIENCE = 30.0
"""So long a step waits for the arm [s]."""


def script(text, chunk=1000):
    reader, writer = os.pipe()
    made = Script(reader, "keys.txt")
    data = text.encode()
    for start in range(0, len(data), chunk):
        os.write(writer, data[start : start + chunk])
        made.read()
    os.close(writer)
    made.read()
    os.close(reader)
    return made


def keys(made):
    """All keys, with a new rest always at hand."""
    moment = 0.0
    while not made.over:
        key = made.due(moment, moment, None)
        moment += 1.0
        if key:
            yield key


@pytest.mark.parametrize("chunk", [1, 3, 1000])
@by_table("text", "pressed")
def test_words_become_keys(text, pressed, chunk):
    assert "".join(keys(script(text, chunk))) == pressed


@pytest.mark.parametrize(
    "word", ["x", "a*", "a*x", "wait", "wait=", "wait=x", "a,s", "!", "*3", "delete=", "relabel=1"]
)
def test_a_word_without_a_meaning_is_told(word):
    with pytest.raises(MukcaError, match=r"keys\.txt: .* is no word of a key script") as caught:
        script(f"a s\n{word} q")
    assert repr(word) in str(caught.value)


@pytest.mark.parametrize("text", ["", "# nothing", " \n\n"])
def test_a_script_without_keys_is_told(text):
    with pytest.raises(MukcaError, match="holds no keys"):
        script(text)


def test_a_capture_waits_for_a_new_rest_and_other_keys_do_not():
    made = script("s a !a q")
    assert made.due(0.0, 0.0, "moving") == "s"
    assert made.due(0.0, 0.0, "moving") is None
    assert made.due(1.0, 1.0, None) == "a"
    assert made.due(1.0, 1.0, "moving") == "a"
    assert made.due(1.0, 1.0, "moving") == "q"
    assert made.over


def test_a_pause_goes_by_the_robot_s_clock():
    made = script("wait=2 q")
    assert made.due(0.0, 100.0, None) is None
    assert made.due(9.0, 101.9, None) is None
    assert made.due(9.1, 102.0, None) == "q"


def test_a_pipe_that_is_still_open_is_not_over():
    reader, writer = os.pipe()
    made = Script(reader)
    os.write(writer, b"a s")
    made.read()
    assert made.due(0.0, 0.0, None) is None and made.hungry  # the line may go on
    os.write(writer, b"*2\n")
    made.read()
    assert [made.due(0.0, 0.0, None) for _ in range(4)] == ["a", "s", "s", None]
    assert made.hungry and not made.over
    os.close(writer)
    made.read()
    os.close(reader)
    assert made.over


def test_a_device_that_never_ends_is_refused():
    device = os.open("/dev/zero", os.O_RDONLY)
    with pytest.raises(MukcaError, match="/dev/zero: over 1,000,000 letters are no key script"):
        Script(device, "/dev/zero").read()
    os.close(device)
