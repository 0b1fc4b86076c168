"""Keys that the operator chose, and lines that are typed."""

import pytest

from mukca.recorder.terminal import keys_with
from mukca.recorder.terminal.key_bindings import KEYS, KeyMapError, TypedLine


def test_a_pedal_captures_and_the_usual_keys_stay() -> None:
    keys = keys_with(["capture=Enter,pagedown", "undo=B"])
    assert keys["Enter"] == keys["PageDown"] == keys["space"] == "capture"
    assert keys["b"] == "undo"
    assert KEYS.items() <= keys.items()


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("shoot=Enter", "'shoot' is none of capture, undo"),
        ("capture=Pedal", "no key is called 'Pedal'"),
        ("capture=7", "no key is called '7'"),
        ("capture=", "no key is called ''"),
        ("capture", "no key is called ''"),
    ],
)
def test_what_is_no_key_or_action_is_told(setting: str, told: str) -> None:
    with pytest.raises(KeyMapError, match=told):
        keys_with([setting])


def test_a_line_is_typed_with_digits_blanks_and_backspace() -> None:
    prompt = TypedLine("relabel")
    for key in ("1", "2", "x", "Backspace", "3", "space", "1"):
        prompt = prompt.with_key(key)
    assert prompt.numbers == [13, 1] and "13 1_" in prompt.text
