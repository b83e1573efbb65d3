"""Exceptions of the package. Each text is one sentence; errors of the C library keep its text."""
import os
import sys
import warnings
from enum import IntEnum
from typing import Dict, Type


class ErrorCode(IntEnum):
    """FIRE3DV_ERROR_* of client.h."""
    ARGUMENT = -1
    STATE = -2
    SYSTEM = -3
    TIMEOUT = -4
    BUDGET = -5
    REFUSED = -6


class Error(RuntimeError):
    """Base class of the exceptions of this package."""

    code: int  #: one of ErrorCode

    def __init__(self, code: int, sentence: str) -> None:
        super().__init__(code, sentence)  # both arguments, so that the exception can be pickled
        self.code = code

    def __str__(self) -> str:
        return str(self.args[1])


class ArgumentError(Error, ValueError):
    """Invalid count, shape, name, number or URI."""


class StateError(Error):
    """Call in the wrong state: publish before describe, or a closed stream."""


class OperatingSystemError(Error):
    """Failure of an operating system call; the text names it."""


class BudgetError(Error):
    """Scene edits exceed scene_budget_bytes."""


class RefusedError(Error):
    """The renderer refused an image request; the text is the renderer's."""


class Timeout(Error, TimeoutError):
    """Timeout of a wait."""


class LibraryNotFound(Error):
    """The C library was not found, or is incompatible with this package."""


class RendererError(Error):
    """The renderer process could not be started, or ended early; the text quotes its last lines."""


class RendererNotFound(RendererError):
    """The program fire3dv was not found; the text has the searched places."""


class SceneWarning(UserWarning):
    """A stream does not do what its program probably means: names without a node, poses that were never filled."""


def warn(text: str) -> None:
    """Warns, at the line of the program that called this package."""
    frame, level = sys._getframe(1), 2
    while frame is not None and frame.f_code.co_filename.startswith(_PACKAGE + os.sep):
        frame, level = frame.f_back, level + 1  # type: ignore[assignment]
    warnings.warn(text, SceneWarning, stacklevel=level)


_PACKAGE = os.path.dirname(__file__)
_OF_CODE: Dict[int, Type[Error]] = {
    ErrorCode.ARGUMENT: ArgumentError, ErrorCode.STATE: StateError, ErrorCode.SYSTEM: OperatingSystemError,
    ErrorCode.BUDGET: BudgetError, ErrorCode.REFUSED: RefusedError,
    ErrorCode.TIMEOUT: Timeout}


def error_of(code: int, sentence: str) -> Error:
    """Returns the exception for an error code of the C library."""
    return _OF_CODE.get(code, Error)(code, sentence)
