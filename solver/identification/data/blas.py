"""Linear algebra by one thread: for matrices as small as here, more cost more than they save."""

from contextlib import ContextDecorator
from functools import cache
from threading import Lock
from typing import Any

from threadpoolctl import ThreadpoolController


@cache
def _controller() -> ThreadpoolController:
    """Controller of the BLAS that NumPy has loaded."""
    return ThreadpoolController().select(user_api="blas")


class _OneThread(ContextDecorator):
    """Limits BLAS to one thread while any call runs, and then restores the caller's number."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._calls = 0
        self._limit: Any = None

    def __enter__(self) -> None:
        with self._lock:
            if not self._calls:
                self._limit = _controller().limit(limits=1)
            self._calls += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._calls -= 1
            if not self._calls:
                self._limit.restore_original_limits()


one_blas_thread = _OneThread()
"""Context and decorator of whatever fits, so that callers need not limit the threads of BLAS."""
