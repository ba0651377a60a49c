"""Messages over pipes: eight bytes of length, and a pickle."""

from __future__ import annotations

import pickle
import struct
from typing import Any, BinaryIO

HEAD = struct.Struct("<Q")


def send(stream: BinaryIO, message: object) -> None:
    """Writes a message.

    Raises
    ------
    OSError
        Where nobody reads any more.
    """
    data = pickle.dumps(message, 5)
    stream.write(HEAD.pack(len(data)))
    stream.write(data)
    stream.flush()


def receive(stream: BinaryIO) -> Any:
    """The next message.

    Raises
    ------
    EOFError
        Where the other end is closed, within a message, too.
    """
    return pickle.loads(exactly(stream, HEAD.unpack(exactly(stream, HEAD.size))[0]))


def exactly(stream: BinaryIO, count: int) -> bytes:
    """So many bytes."""
    data = stream.read(count)
    if data is None or len(data) < count:
        raise EOFError
    return data
