"""Exceptions of the package."""


class MusculoCollideError(Exception):
    """Base class of the package's exceptions."""


class InputError(MusculoCollideError, ValueError):
    """Input that the library refuses; the message names the body, the place and the value."""


class ArrayTypeError(MusculoCollideError, TypeError):
    """An array of numbers that cannot be read as points or faces."""


class FileError(MusculoCollideError, OSError):
    """A file that cannot be read or written."""
