"""Address of the page, kept from start to start, so that a tablet need not be told again."""

import json
import os
import secrets
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

LETTERS, LENGTH = "abcdefghijkmnpqrstuvwxyz23456789", 12
"""Of a secret that nobody can guess, and that can be typed into a tablet: 60 bits."""


class PageAddress(NamedTuple):
    """What this computer chooses of the address."""

    port: int
    """0 for any that is free."""
    secret: str


def kept_address() -> PageAddress:
    """Return the address of the start before, or a new one."""
    with suppress(OSError, RuntimeError, ValueError, TypeError, KeyError):
        entries = json.loads(_file().read_text())
        address = PageAddress(int(entries["port"]), str(entries["secret"]))
        if len(address.secret) >= LENGTH and 0 < address.port < 1 << 16:
            return address
    return PageAddress(0, "".join(secrets.choice(LETTERS) for _ in range(LENGTH)))


def keep_address(address: PageAddress) -> None:
    """Keep an address where this user alone can read it, if that can be written."""
    with suppress(OSError, RuntimeError):
        file = _file()
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch(mode=0o600)
        file.write_text(json.dumps(address._asdict()))


def _file() -> Path:
    state = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(state) / "mukca" / "page.json"
