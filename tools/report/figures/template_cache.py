"""Compiled templates, kept where Python keeps compiled modules."""

import marshal
import os
import sys
from contextlib import suppress
from importlib.util import cache_from_source
from pathlib import Path

from jinja2 import BytecodeCache
from jinja2 import __version__ as jinja_version
from jinja2.bccache import Bucket

from ...._version import __version__


class TemplateCache(BytecodeCache):
    """Keeps compiled templates in ``__pycache__``, and does without where none can be written."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def get_source_checksum(self, source: str) -> str:
        """Return the checksum of a template and of what compiles it."""
        return super().get_source_checksum(f"{__version__} {jinja_version} {source}")

    def load_bytecode(self, bucket: Bucket) -> None:
        """Read a compiled template, if there is one of this source."""
        with suppress(OSError, EOFError, ValueError, TypeError):
            content = self._file(bucket).read_bytes()
            checksum, code = marshal.loads(content)  # noqa: S302  (as trusted as the modules beside it)
            if checksum == bucket.checksum:
                bucket.code = code

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Write a compiled template."""
        if sys.dont_write_bytecode:
            return
        file = self._file(bucket)
        unfinished = file.with_suffix(f".{os.getpid()}")
        with suppress(OSError):
            file.parent.mkdir(parents=True, exist_ok=True)
            unfinished.write_bytes(marshal.dumps((bucket.checksum, bucket.code)))
            unfinished.replace(file)

    def _file(self, bucket: Bucket) -> Path:
        """Return the file of a compiled template, another for each version of Python."""
        return Path(cache_from_source(str(self.folder / f"{bucket.key}.j2")))
