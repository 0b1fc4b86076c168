"""Keys of actions, and their names in texts: ``{finish}`` stands for the key that finishes."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from ...errors import read_json

KEYS: dict[str, str] = read_json(Path(__file__).with_name("keys.json"))
"""Default action of each key, first the one that texts name; digits choose a socket."""
_ACTION = re.compile(r"\{(\w+)\}")


def key_names(keys: Mapping[str, str]) -> dict[str, str]:
    """Return the key of each action: the first that the operator chose, or the default one."""
    chosen = [item for item in keys.items() if item not in KEYS.items()]
    return {action: key for key, action in reversed([*chosen, *keys.items()])}


def all_key_names(keys: Mapping[str, str]) -> dict[str, str]:
    """Return all keys of each action, in the order of their definition."""
    actions = dict.fromkeys(keys.values())
    return {action: ", ".join(_keys_of(keys, action)) for action in actions}


def _keys_of(keys: Mapping[str, str], action: str) -> Iterable[str]:
    return (key for key, does in keys.items() if does == action)


def with_key_names(text: str, names: Mapping[str, str]) -> str:
    """Return a text with the names of keys in the place of actions in braces."""
    return _ACTION.sub(lambda match: names.get(match[1], match[0]), text)
