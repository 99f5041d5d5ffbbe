"""Exceptions of the package, and the warning about a case."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NoReturn, Optional, TypeVar, cast

_WRONG_ARGUMENTS = 2
#: Exceptions with this attribute were raised by a function of the caller.
_PASSES = "_raised_by_caller"
_Function = TypeVar("_Function", bound=Callable[..., Any])


class Error(Exception):
    """Why there is no result.

    Attributes
    ----------
    place : str or None
        Where: the line of a case file, the dotted key of a dict or a problem (``body.0.displacement.1.ux``), or `None`.
    found : str
        What was found.
    expected : str or None
        What was expected there.
    fix : str or None
        One thing that helps.
    code : int
        The exit status of the command ``nndd`` for the same failure.
    findings : list of dict
        Everything that is wrong, each with ``place``, ``found``, ``expected`` and ``fix``; the first is that of the attributes.

    Examples
    --------
    >>> import nndd
    >>> try:
    ...     nndd.solve({"schema": 1, "materials": {"steel": {"young": -1.0, "poisson": 0.3}}, "body": [], "contact": []})
    ... except nndd.Error as error:
    ...     print(type(error).__name__, error.code, error.findings[0]["place"])
    InvalidInput 3 materials.steel.young
    """

    place: Optional[str]
    found: str
    expected: Optional[str]
    fix: Optional[str]
    code: int
    findings: list[dict[str, Optional[str]]]

    def __init__(self, code: int, findings: Sequence[Mapping[str, Optional[str]]]) -> None:
        self.findings = [{key: text and of_python(text) for key, text in finding.items()} for finding in findings]
        first = self.findings[0] if self.findings else {}
        self.code = code
        self.place = first.get("place")
        self.found = first.get("found") or ""
        self.expected = first.get("expected")
        self.fix = first.get("fix")
        super().__init__("\n".join(_sentence(finding) for finding in self.findings))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.code, self.findings)


class InvalidInput(Error, ValueError):
    """Arguments or a case that make no sense (codes 2 and 3)."""


class NotSolvable(Error):
    """A problem without a unique solution: a body can move freely, or its loads are outside the friction cones (code 4)."""


class FileError(Error, OSError):
    """Files that cannot be read or written (code 7)."""


class LimitReached(Error):
    """Too little memory or time for a first result (code 8)."""


class CaseWarning(UserWarning):
    """What a case allows and is probably not meant."""


_CLASSES: dict[int, type[Error]] = {
    2: InvalidInput,
    3: InvalidInput,
    4: NotSolvable,
    7: FileError,
    8: LimitReached,
}


#: What fixes say of options of the command, and what it is here.
_OPTIONS = [
    ("continue it with --resume, or start again with --force", "start again with force=True"),
    (" with --out", ""),
    ("--force", "force=True"),
    ("--set solver.method=nndd", 'solver__method="nndd"'),
    ("; raise the limit and continue with --resume", "; raise the limit"),
    ("; continue with --resume", ""),
]


def of_python(text: str) -> str:
    """Name arguments of the package instead of options of the command."""
    for option, here in _OPTIONS:
        text = text.replace(option, here)
    return text


def _sentence(finding: Mapping[str, Optional[str]]) -> str:
    place, found = finding.get("place"), finding.get("found") or ""
    text = f"{place}: {found}" if place else found
    if finding.get("expected"):
        text += f"\n  expected: {finding['expected']}"
    if finding.get("fix"):
        text += f"\n  fix: {finding['fix']}"
    return text


def of_failure(code: int, findings: Sequence[Mapping[str, Optional[str]]]) -> Error:
    """Make the exception of a failure of the library."""
    return _CLASSES.get(code, Error)(code, findings)


def of_caller(function: _Function) -> _Function:
    """Mark what a function of the caller raises: it passes through."""

    @functools.wraps(function)
    def called(*arguments: Any) -> Any:
        try:
            return function(*arguments)
        except Exception as error:
            error.__dict__[_PASSES] = True
            raise

    return cast(_Function, called)


def refusing(function: _Function) -> _Function:
    """Make an `Error` of what Python says of arguments that cannot be converted."""

    @functools.wraps(function)
    def called(*arguments: Any, **options: Any) -> Any:
        try:
            return function(*arguments, **options)
        except Error:
            raise
        except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
            if _PASSES in error.__dict__:
                raise
            said = str(error) or type(error).__name__
            finding = {
                "place": None,
                "found": said,
                "expected": "arguments of the types that the documentation names",
                "fix": f"see help(nndd.{function.__qualname__})",
            }
            raise InvalidInput(_WRONG_ARGUMENTS, [finding]) from error

    return cast(_Function, called)


def refuse(place: Optional[str], found: str, expected: str, fix: str) -> NoReturn:
    """Raise the exception of a wrong argument."""
    raise InvalidInput(_WRONG_ARGUMENTS, [{"place": place, "found": found, "expected": expected, "fix": fix}])


def needs(package: str, error: ImportError) -> ImportError:
    """Make the exception of an optional package that is absent."""
    return ImportError(f"this needs the package {package}: pip install {package}", name=error.name)
