"""Exceptions of the package."""


class MusculoCollideError(Exception):
    """Base class of the package's exceptions."""


class InputError(MusculoCollideError, ValueError):
    """Input that the library refuses; the message names the body, the place and the value."""


class InputTypeError(MusculoCollideError, TypeError):
    """Input of a type that cannot be read as what it is for."""


class InUseError(MusculoCollideError, RuntimeError):
    """An object that another call is using, in this thread or in another one."""


class FileError(MusculoCollideError, OSError):
    """A file that cannot be read or written."""
