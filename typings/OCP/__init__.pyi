# OCP has no types, and is installed for STEP files alone.
from typing import Any

def __getattr__(name: str) -> Any: ...
