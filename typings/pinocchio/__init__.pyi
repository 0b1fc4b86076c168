# Pinocchio's types are those of its C++ bindings.
from typing import Any

def __getattr__(name: str) -> Any: ...
