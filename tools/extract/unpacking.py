"""Compressed bags, unpacked no further than those of robots go: kilobytes may hold gigabytes."""

import sys
from bz2 import BZ2Decompressor
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .log import ExtractError

LARGEST_CHUNK = 100_000_000
"""Size to which a chunk or a message is unpacked at most [bytes]."""
LARGEST_BAG = 5_000_000_000
"""Size to which a whole file is unpacked at most, on the disk [bytes]."""
MOST_NUMBERS = 50_000_000
"""Numbers in a file of a data set at most: of equal ones, a kilobyte holds millions."""
ZSTD = b"\x28\xb5\x2f\xfd"
"""First bytes of a file that is compressed as a whole."""


def bound_chunks() -> Callable[[bytes], bytes]:
    """Let rosbags unpack no chunk beyond the bound, and return what unpacks a message so.

    What a header declares may be wrong, so that the bytes are counted as they come.
    """
    from lz4.frame import (  # pyright: ignore[reportMissingTypeStubs]
        LZ4FrameDecompressor,
    )
    from rosbags.rosbag1 import reader
    from rosbags.rosbag2 import storage_mcap

    bz2, lz4 = _bounded(BZ2Decompressor), _bounded(LZ4FrameDecompressor)
    unpack_message = _bounded(_zstd().ZstdDecompressor)
    reader.decompressors.update(bz2=bz2, lz4=lz4)
    storage_mcap.DECOMPRESSORS.update(lz4=lz4, zstd=unpack_message)
    return unpack_message


def _zstd() -> Any:
    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    return zstd


def _bounded(decompressor: Callable[[], Any]) -> Callable[..., bytes]:
    def unpack(data: bytes, _: int = 0) -> bytes:
        content: bytes = decompressor().decompress(data, max_length=LARGEST_CHUNK + 1)
        if len(content) > LARGEST_CHUNK:
            raise _too_large(f"{len(data) / 1e3:,.1f} kB of it", LARGEST_CHUNK)
        return content

    return unpack


def require_bounded(file: Path) -> None:
    """See that a file, if it is compressed as a whole, has no more in it than the disk can take."""
    with file.open("rb") as stream:
        if stream.read(len(ZSTD)) != ZSTD:
            return
    size = 0
    with _zstd().open(file) as stream:
        while part := stream.read(1 << 20):
            size += len(part)
            if size > LARGEST_BAG:
                raise _too_large(file.name, LARGEST_BAG)


def require_few_numbers(file: Path, metadata: Any) -> None:
    """See that a parquet file declares no more numbers than the frames of a robot have."""
    count = 0
    for i in range(metadata.num_row_groups):
        group = metadata.row_group(i)
        count += sum(group.column(j).num_values for j in range(group.num_columns))
    if count > MOST_NUMBERS:
        raise ExtractError(f"{file}: {count} numbers; at most {MOST_NUMBERS} are read")


def _too_large(part: str, largest: int) -> ExtractError:
    return ExtractError(
        f"{part} unpack to more than {largest / 1e6:,.0f} MB, as no bag of a robot does"
    )
