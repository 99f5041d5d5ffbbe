"""Cases: a file, a dict of its keys, or what has such a dict."""

from __future__ import annotations

import numbers
import os
from collections.abc import Callable, Mapping
from typing import Any, Optional, Protocol, Union

from . import _nndd
from ._errors import refuse


class HasKeys(Protocol):
    """What makes the keys of a case, such as a `Problem`."""

    def to_dict(self) -> dict[str, Any]:
        """Return them."""
        ...


CaseLike = Union[str, "os.PathLike[str]", Mapping[str, Any], HasKeys]
Progress = Callable[[dict[str, Any]], object]


def native(case: CaseLike) -> _nndd.Case:
    """Make the case of the library."""
    if isinstance(case, (str, os.PathLike)):
        return _nndd.Case.file(os.fspath(case))
    if isinstance(case, Mapping):
        return _nndd.Case.keys(case)
    if not hasattr(case, "to_dict"):
        refuse(None, f"a case of type {type(case).__name__}", "a path, a dict or a Problem", "check the argument")
    return _nndd.Case.keys(case.to_dict())


def threads_of(threads: Optional[int]) -> int:
    """Return the number of threads, 0 for one per core."""
    if threads is None:
        return 0
    if isinstance(threads, bool) or not isinstance(threads, numbers.Integral) or threads < 1:
        refuse("threads", f"{threads!r}", "a whole number >= 1, or None for one per core", "leave it out")
    return int(threads)
