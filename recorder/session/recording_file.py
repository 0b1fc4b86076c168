"""A placement's files, open for recording: append-only, locked, and safe against a crash."""

import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from ...errors import read_bytes
from .. import (
    APPEND,
    METADATA,
    SAMPLES,
    Metadata,
    RecordingError,
    Sample,
    SampleFile,
    append_bytes,
    capture_line,
    header_line,
    is_placement,
    lock_file,
    make_folder,
    mark_line,
    next_folder,
    placements_in,
    read_metadata,
    read_samples,
    refused,
    replace_files,
    sync_folder,
    with_kept_alarm,
    with_reading,
    write_metadata,
)


class Recording:
    """The files of one placement, new or continued; no other recorder can open them meanwhile.

    If an error ends the block of a ``with`` before the first capture, new files are removed.

    Raises:
        RecordingError: The folder cannot be written to, holds something else, belongs to another
            robot, joints or distance, or is being recorded by another program.
    """

    def __init__(self, folder: Path, metadata: Metadata) -> None:
        self.folder = folder
        self.metadata = metadata
        """Metadata that this start gave."""
        self.file = folder / SAMPLES
        self.remarks: list[str] = []
        """Remarks to the operator on files that were there already."""
        self._agree(metadata)
        self._is_new = False
        self._new_folders: list[Path] = []
        with refused(f"{self.file}: cannot be written"):
            self._new_folders = make_folder(folder)
            flags = os.O_RDWR | os.O_CREAT | APPEND
            self._fd = os.open(self.file, flags, 0o666)
        try:
            try:
                lock_file(self._fd)
            except BlockingIOError:
                raise RecordingError(
                    f"{folder}: another mukca record is writing there; finish it first"
                ) from None
            # Another program may have written there before the lock.
            stored = self._agree(metadata)
            # A description that somebody wrote beforehand stays, whatever happens.
            described = (folder / METADATA).exists()
            self._is_new = not described and not os.fstat(self._fd).st_size
            self.content = self._mend(metadata.joints)
            model = metadata.model_sha256
            if stored.get("model_sha256", model) != model:
                self.remarks.append(
                    "the robot's model has changed since this recording was begun"
                )
            self._metadata = metadata.added_to(stored)
            write_metadata(folder, self._metadata)
            self._size = os.fstat(self._fd).st_size
        except BaseException as error:
            os.close(self._fd)
            if isinstance(error, OSError):
                if self._is_new:
                    self._remove()
                raise RecordingError(
                    f"{folder}: cannot be written: {error.strerror}"
                ) from None
            raise

    def capture(self, sample: Sample) -> None:
        """Append a capture; it is on the disk when this returns."""
        self._append(capture_line(sample))

    def mark(self, event: str, samples: Sequence[Sample], time: float) -> None:
        """Append a mark on each of some earlier samples, or on none; their lines stay."""
        self._append(b"".join(mark_line(event, sample, time) for sample in samples))

    def begin_next(self, metadata: Metadata, samples: Sequence[Sample]) -> "Recording":
        """Begin the next placement of the series, with samples from here.

        Raises:
            RecordingError: Its files cannot be written; then none of them stays.
        """
        successor = Recording(next_folder(self.folder), metadata)
        try:
            for number, sample in enumerate(samples, 1):
                successor.capture(replace(sample, number=number))
            successor.content = read_samples(successor.file)
        except RecordingError:
            successor.discard()
            raise
        return successor

    def discard(self) -> None:
        """Release and remove the files, whose samples are elsewhere."""
        self.close()
        self._remove()

    def set_socket(self, socket: int) -> None:
        """Remember in which socket the ball is, so that a later start goes on there."""
        if socket != self._metadata.get("socket"):
            self._write({**self._metadata, "socket": socket})

    def keep_alarm(self, text: str) -> None:
        """Remember what an alarm said, and the operator kept as it was."""
        self._write(with_kept_alarm(self._metadata, text))

    @property
    def distance(self) -> float | None:
        """The last reading of the sockets' distance [m], if any."""
        distance = self._metadata.get("distance")
        return distance if isinstance(distance, int | float) else None

    def add_reading(self, distance: float) -> None:
        """Write a further reading of the sockets' distance [m]."""
        self._write(with_reading(self._metadata, distance))

    def _write(self, metadata: dict[str, Any]) -> None:
        self._check_place()
        with refused(f"{METADATA} cannot be written"):
            write_metadata(self.folder, metadata)
        self._metadata = metadata

    @property
    def socket(self) -> int:
        """The socket in which the ball was last, as far as the files know."""
        last = self.content.live[-1].socket if self.content.live else 0
        saved = self._metadata.get("socket", last)
        return saved if isinstance(saved, int) else last

    def close(self) -> None:
        """Release the files; safe to call twice."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def __enter__(self) -> "Recording":
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        self.close()
        if error and self._is_new:
            self._remove()

    def _remove(self) -> None:
        """Remove files without a sample, and the folders that were made for them."""
        with suppress(OSError):
            self.file.unlink(missing_ok=True)
            (self.folder / METADATA).unlink(missing_ok=True)
            for folder in self._new_folders:
                folder.rmdir()

    def _agree(self, metadata: Metadata) -> dict[str, Any]:
        """Return the metadata of an earlier session, if they describe the same placement."""
        if not self.folder.exists():
            return {}
        if not self.folder.is_dir():
            raise RecordingError(f"{self.folder}: not a folder")
        if not self.file.exists() and is_placement(self.folder):
            raise RecordingError(
                f"{self.folder}: holds a recording in the form hole_0.csv; choose another --out"
            )
        if not self.file.exists() and (inside := placements_in(self.folder)):
            raise RecordingError(
                f"{self.folder}: holds placements ({', '.join(p.name for p in inside[:3])}), so it "
                f"cannot be one; name a folder for the new one, as in {self.folder / 'next'}"
            )
        stored = read_metadata(self.folder / METADATA)
        for key, value in metadata.fixed().items():
            if key in stored and stored[key] != value:
                remedy = "choose another --out to begin anew"
                if key == "distance":
                    correct = f"mukca info {self.folder} --set-distance {value}"
                    remedy = f"leave --distance out, or correct it by {correct} first"
                raise RecordingError(
                    f"{self.folder / METADATA}: recorded with {key} {_text(stored[key])}, "
                    f"not {_text(value)}; {remedy}"
                )
        return stored

    def _mend(self, joints: tuple[str, ...]) -> SampleFile:
        """Move a torn line aside, give a new file its header, and return what the file holds."""
        lines, newline, torn = read_bytes(self.file).rpartition(b"\n")
        if torn:
            count = 1
            while (aside := self.folder / f"{SAMPLES}.torn-{count}").exists():
                count += 1
            replace_files({aside: torn})
            self.remarks.append(
                f"the last line of {SAMPLES} was torn off by a crash; it is kept in {aside.name}"
            )
            os.ftruncate(self._fd, len(lines) + len(newline))
        if not lines:
            os.ftruncate(self._fd, 0)
            append_bytes(self._fd, header_line(joints))
        os.fsync(self._fd)
        sync_folder(self.folder)
        content = read_samples(self.file)
        if content.joint_names != joints:
            raise RecordingError(
                f"{self.file}:1: recorded with joints {_text(content.joint_names)}, "
                f"not {_text(joints)}; choose another --out to begin anew"
            )
        return content

    def _append(self, line: bytes) -> None:
        self._check_place()
        if os.fstat(self._fd).st_size != self._size:
            raise RecordingError(
                f"{self.file.name} was changed by another program; end the session, and start again"
            )
        try:
            append_bytes(self._fd, line)
        except OSError as error:
            raise RecordingError(
                f"{self.file.name} cannot be written to: {error.strerror}; nothing was lost"
            ) from None
        self._size += len(line)
        self._is_new = False

    def _check_place(self) -> None:
        """See that the open file is still the one that its path names."""
        try:
            status = self.file.stat()
        except OSError:
            status = None
        if status is None or not os.path.samestat(status, os.fstat(self._fd)):
            raise RecordingError(
                f"{self.file} was moved, renamed or replaced; end the session, and start again "
                "with --out where it is now"
            )


def _text(value: object) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(map(str, cast("Sequence[object]", value)))
    return str(value)
