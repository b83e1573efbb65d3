"""Exceptions of the package. Each text is one sentence; errors of the C library keep its text."""
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
    """Base of all that this package raises."""

    code: int  #: one of ErrorCode

    def __init__(self, code: int, sentence: str) -> None:
        super().__init__(code, sentence)  # both arguments, so that the exception can be pickled
        self.code = code

    def __str__(self) -> str:
        return str(self.args[1])


class ArgumentError(Error, ValueError):
    """A count, shape, name, number or URI that is not valid."""


class StateError(Error):
    """Publish before describe; a closed stream."""


class OperatingSystemError(Error):
    """The operating system refused; the text says what."""


class BudgetError(Error):
    """Scene edits together would take more than scene_budget_bytes."""


class RefusedError(Error):
    """The renderer does not make this image; the text is its own."""


class Timeout(Error, TimeoutError):
    """What was waited for has not come in time."""


class LibraryNotFound(Error):
    """The C library is nowhere, or is not one that this package can use."""


_OF_CODE: Dict[int, Type[Error]] = {
    ErrorCode.ARGUMENT: ArgumentError, ErrorCode.STATE: StateError, ErrorCode.SYSTEM: OperatingSystemError,
    ErrorCode.BUDGET: BudgetError, ErrorCode.REFUSED: RefusedError,
    ErrorCode.TIMEOUT: Timeout}


def error_of(code: int, sentence: str) -> Error:
    """The exception for a code of the C library."""
    return _OF_CODE.get(code, Error)(code, sentence)
