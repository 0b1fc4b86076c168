"""How many files and types a run of the program passes, as a reader meets them who follows it.

    python benchmarks/passage.py solve TRAIN --test HELD_OUT --robot R --out DIR --force

Files are those of the package with a function that is called. Types are its classes of which a
function returns an instance to a function of another file.
"""

import sys
from pathlib import Path
from types import FrameType

import mukca
from mukca.__main__ import run

ROOT = str(Path(mukca.__file__).parent)


class Passage:
    """The files and types that a run has passed so far."""

    def __init__(self) -> None:
        self.files: set[str] = set()
        self.types: set[type] = set()

    def __call__(self, frame: FrameType, event: str, result: object) -> None:
        """Note an event, as :func:`sys.setprofile` reports it."""
        file = _file_of(frame)
        if not file or frame.f_code.co_name == "<module>":
            return
        if event == "call":
            self.files.add(file)
            return
        goes_on = _file_of(frame.f_back) not in ("", file)
        if goes_on and type(result).__module__.startswith("mukca."):
            self.types.add(type(result))


def _file_of(frame: FrameType | None) -> str:
    """Return the package's file that a frame is in; empty for another."""
    name = frame.f_code.co_filename if frame else ""
    is_ours = name.startswith(ROOT) and "site-packages" not in name
    return name if is_ours else ""


def main() -> None:
    passage = Passage()
    sys.setprofile(passage)
    try:
        run()
    finally:
        sys.setprofile(None)
        print(
            f"{len(passage.files)} files, {len(passage.types)} types", file=sys.stderr
        )


if __name__ == "__main__":
    main()
