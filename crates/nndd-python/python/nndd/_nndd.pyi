"""The native part."""

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Optional, Union, final

import numpy.typing as npt

from ._data import Floats

__all__ = ["CELL_FIELDS", "POINT_FIELDS", "Case", "Solution", "__version__", "generate", "read_mesh"]

__version__: str
POINT_FIELDS: list[str]
CELL_FIELDS: list[str]

@final
class Case:
    @staticmethod
    def keys(keys: Mapping[str, Any]) -> Case: ...
    @staticmethod
    def file(path: str) -> Case: ...
    def solve(self, set: Mapping[str, Any], threads: int, callback: Optional[Callable[[dict[str, Any]], object]]) -> Solution: ...
    def check(self, set: Mapping[str, Any], threads: int) -> dict[str, Any]: ...
    def sweep(
        self,
        over: str,
        set: Mapping[str, Any],
        iterations: int,
        panel: Sequence[str],
        out: Optional[str],
        force: bool,
        threads: int,
        callback: Optional[Callable[[dict[str, Any]], object]],
    ) -> str: ...
    def certify(
        self,
        set: Mapping[str, Any],
        displacements: Sequence[Floats],
        pressures: Optional[Sequence[Floats]],
        threads: int,
    ) -> tuple[dict[str, Any], list[tuple[dict[str, Any], Floats]]]: ...
    def mesh(self, body: int) -> dict[str, Any]: ...

@final
class Solution:
    def report(self) -> str: ...
    def verdict(self) -> str: ...
    def warnings(self) -> list[str]: ...
    def mesh(self, body: int) -> dict[str, Any]: ...
    def field(self, body: int, name: str) -> Optional[npt.NDArray[Any]]: ...
    def contact(self, pair: int) -> dict[str, Any]: ...
    def save(self, directory: str, force: bool) -> list[str]: ...

def generate(keys: Mapping[str, Any]) -> dict[str, Any]: ...
def read_mesh(path: Union[str, os.PathLike[str]]) -> tuple[dict[str, Any], list[str]]: ...
