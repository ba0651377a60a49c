"""Everything that shadowlab raises derives from `ShadowlabError` and from the builtin that fits."""


class ShadowlabError(Exception):
    """Base of all errors of this package.

    Attributes
    ----------
    fix : str
        What to do, where the message ends in that; else empty.
    """

    fix: str = ""

    def __str__(self) -> str:
        """The message on one line that every file takes, whatever names of files and columns it holds."""
        return " ".join(super().__str__().splitlines()).encode("utf-8", "backslashreplace").decode("utf-8")


class ArgumentError(ShadowlabError, ValueError):
    """An argument of the wrong type, shape or range."""


class UnknownNameError(ShadowlabError, ValueError):
    """A name that is in no registry; the message lists the valid ones."""


class SceneError(ShadowlabError, ValueError):
    """Geometry that cannot be used: no triangle left, a face that points nowhere."""


class LoadError(ShadowlabError, OSError):
    """A file that is missing, broken or not a mesh."""


class UnsupportedError(ShadowlabError, ValueError):
    """A technique asked to serve what it cannot.

    Attributes
    ----------
    technique : str
        The technique that refuses a light or a view; empty where there is none.
    reason : str
        The message without the technique's name; empty where `technique` is.
    """

    technique: str = ""
    reason: str = ""


class DeviceError(ShadowlabError, RuntimeError):
    """No graphics adapter, or one that failed."""


class WorkerError(ShadowlabError, RuntimeError):
    """A process that works for another one: it cannot be started, or it ended before its work was done."""


class StateError(ShadowlabError, ValueError):
    """A pickle that is damaged or was written by a newer version, or an object that cannot be pickled."""


class StoreError(ShadowlabError, OSError):
    """A store of runs that cannot be read or written; the message names the file.

    Attributes
    ----------
    problem : str
        "missing" (no such file or folder), "foreign" (a file of another program), "newer" (written by a newer
        shadowlab), "damaged", "locked" (another process writes), "read_only", "full" (no room on the disk), "closed",
        or "disk" for other errors of the system.
    """

    problem: str = ""


class InternalError(ShadowlabError, RuntimeError):
    """A defect in shadowlab itself."""


class ShadowlabWarning(UserWarning):
    """Something was left out or replaced; the message says what and how much."""
