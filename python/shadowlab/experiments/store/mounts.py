"""Which file system a path lies on: a store in WAL mode needs memory that its processes share, so one machine."""

from __future__ import annotations

import re
from pathlib import Path

#: Types of file systems that several machines write to, as Linux lists them; "fuse." names a program of the user's.
NETWORK = frozenset(
    {
        "9p", "afs", "afpfs", "beegfs", "ceph", "cifs", "davfs", "fuse.ceph", "fuse.cephfs", "fuse.davfs",
        "fuse.gcsfuse", "fuse.glusterfs", "fuse.goofys", "fuse.juicefs", "fuse.moosefs", "fuse.s3fs", "fuse.sshfs",
        "fuse.rclone", "gfs2", "glusterfs", "gpfs", "lustre", "ncpfs", "nfs", "nfs4", "ocfs2", "orangefs", "panfs",
        "pvfs2", "smb2", "smb3", "smbfs", "virtiofs", "wekafs",
    }
)  # fmt: skip
MOUNTS = Path("/proc/self/mountinfo")


def network_type(path: Path, mounts: str | None = None) -> str:
    """The type of the network file system that a path lies on; empty on a local one, and where it is not known.

    Parameters
    ----------
    path : Path
        Of a file; its folder must be there.
    mounts : str, optional
        What to read instead of this system's list of mounts, in the format of ``/proc/self/mountinfo``.
    """
    try:
        text = MOUNTS.read_text(encoding="utf-8", errors="surrogateescape") if mounts is None else mounts
        folder = path.parent.resolve()
    except OSError:
        return ""  # not Linux: what cannot be asked is taken for local
    best, kind = -1, ""
    for line in text.splitlines():
        words, _, after = line.partition(" - ")
        fields, types = words.split(), after.split()
        if len(fields) < 5 or not types:
            continue
        point = Path(_unescaped(fields[4]))
        # Of several mounts on one point the last hides the others.
        if folder.is_relative_to(point) and len(point.parts) >= best:
            best, kind = len(point.parts), types[0]
    return kind if kind in NETWORK else ""


def _unescaped(text: str) -> str:
    """A mount point as it is: blanks and backslashes are octal numbers in the list."""
    return re.sub(r"\\([0-7]{3})", lambda found: chr(int(found[1], 8)), text)
