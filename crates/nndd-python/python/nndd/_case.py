"""Cases of dicts: the text that the library reads, with the meshes and data that it names."""

from __future__ import annotations

import json
import numbers
import os
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from . import _nndd
from ._data import floats, is_masked
from ._errors import refuse

if TYPE_CHECKING:
    from ._model import Mesh, Problem

    CaseLike = Union[str, os.PathLike[str], Mapping[str, Any], Problem]

#: Keys that take data at nodes.
_DATUM = re.compile(
    r"body\.\d+\.(displacement\.\d+\.(ux|uy|normal)|traction\.\d+\.(pressure|vector\.[01]))|contact(\.\d+)?\.(gap|friction\.limit)"
)
_VECTOR = re.compile(r"body\.\d+\.traction\.\d+\.vector")
_BARE = re.compile(r"[A-Za-z0-9_-]+")


def native(case: CaseLike) -> _nndd.Case:
    """Make the case of the library."""
    from ._model import Problem

    if isinstance(case, Problem):
        case = case.to_dict()
    if isinstance(case, Mapping):
        writer = _Writer()
        writer.table(case, [], "")
        text = "\n".join(writer.lines) + "\n"
        meshes = [(name, mesh._given()) for name, mesh in writer.meshes]
        return _nndd.Case.text(text, "problem", "", writer.keys, meshes, writer.data)
    try:
        return _nndd.Case.file(os.fspath(case))
    except TypeError:
        refuse(None, f"a case of type {type(case).__name__}", "a path, a dict or a Problem", "check the argument")


def settings(overrides: Mapping[str, Any]) -> list[str]:
    """Write settings as the command has them; two underscores of a keyword are a dot."""
    return [f"{key.replace('__', '.')}={_inline(value, key)}" for key, value in overrides.items()]


def threads_of(threads: Optional[int]) -> int:
    """Return the number of threads, 0 for one per core."""
    if threads is None:
        return 0
    if isinstance(threads, bool) or not isinstance(threads, numbers.Integral) or threads < 1:
        refuse("threads", f"{threads!r}", "a whole number >= 1, or None for one per core", "leave it out")
    return int(threads)


class _Writer:
    """Writes a dict as TOML, one key per line, and keeps what text cannot hold."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        #: The dotted key of each line.
        self.keys: list[str] = []
        self.meshes: list[tuple[str, Mesh]] = []
        self.data: list[tuple[str, Any]] = []

    def put(self, line: str, key: str) -> None:
        self.lines.append(line)
        self.keys.append(key)

    def table(self, table: Mapping[str, Any], header: list[str], path: str) -> None:
        """Write the keys of a table; those of tables below it come last."""
        below: list[tuple[str, Any]] = []
        for key, value in table.items():
            if not isinstance(key, str):
                refuse(path or None, f"the key {key!r}", "keys that are strings", "write it in quotes")
            here = f"{path}.{key}" if path else key
            value = self.with_mesh(key, value)
            if value is None:
                continue
            if isinstance(value, Mapping) or _is_list_of_tables(value):
                below.append((key, value))
            else:
                self.put(f"{_key(key)} = {self.value(value, here)}", here)
        for key, value in below:
            here, names = f"{path}.{key}" if path else key, [*header, _key(key)]
            if isinstance(value, Mapping):
                self.put(f"[{'.'.join(names)}]", here)
                self.table(value, names, here)
                continue
            for k, entry in enumerate(value):
                self.put(f"[[{'.'.join(names)}]]", f"{here}.{k}")
                self.table(entry, names, f"{here}.{k}")

    def with_mesh(self, key: str, value: Any) -> Any:
        """Replace a mesh in memory by its name."""
        from ._model import Mesh

        if isinstance(value, Mesh):
            return self.named(value) if key == "file" else {"file": self.named(value)}
        return value

    def named(self, mesh: Mesh) -> str:
        for name, other in self.meshes:
            if other is mesh:
                return name
        name = f"<mesh {len(self.meshes) + 1}>"
        self.meshes.append((name, mesh))
        return name

    def value(self, value: Any, path: str) -> str:
        if _VECTOR.fullmatch(path) and not isinstance(value, str):
            if callable(value):
                refuse(path, "a function for both components", "a function for each of them", "write (fx, fy)")
            if isinstance(value, np.ndarray) and value.ndim == 2:
                both = floats(value, path, (None, 2))
                value = [both[:, 0], both[:, 1]]
            if isinstance(value, (Sequence, np.ndarray)):
                parts = [self.value(part, f"{path}.{k}") for k, part in enumerate(value)]
                return f"[{', '.join(parts)}]"
        if _DATUM.fullmatch(path):
            if callable(value):
                self.data.append((path, value))
                return "0.0"
            if isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str) and np.ndim(value) > 0:
                # What is not finite away from the side does no harm.
                self.data.append((path, _nodal(value, path)))
                return "0.0"
        return _inline(value, path)


def _nodal(value: Any, path: str) -> Any:
    if is_masked(value):
        floats(value, path, (None,))
    array = np.asarray(value)
    if array.dtype.kind not in "fiu" or array.ndim != 1:
        floats(value, path, (None,))
    return np.ascontiguousarray(array, dtype=np.float64)


def _is_list_of_tables(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(v, Mapping) for v in value)


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else _quoted(key)


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _inline(value: Any, path: str) -> str:
    """Write a value on one line."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, os.PathLike):
        return _quoted(str(os.fspath(value)))
    if isinstance(value, np.ndarray):
        if is_masked(value):
            refuse(path, "a masked array", "numbers", "fill it with numbers first, such as by filled(0.0)")
        return _inline(value.tolist(), path)
    if isinstance(value, Mapping):
        entries = [f"{_key(str(key))} = {_inline(entry, path)}" for key, entry in value.items()]
        return f"{{ {', '.join(entries)} }}" if entries else "{}"
    if isinstance(value, Sequence) and not isinstance(value, (bytes, bytearray)):
        return f"[{', '.join(_inline(entry, path) for entry in value)}]"
    found = "a function" if callable(value) else f"a value of type {type(value).__name__}"
    refuse(path, found, "a number, a text, a list or a dict", "see the keys of the case file")
