"""Arrays as they come in: checked, and in the types of the library."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from ._errors import of_caller, refuse

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Function = Callable[[Floats, Floats], npt.ArrayLike]
Pair = Union[tuple[float, float], Sequence[float], npt.NDArray[Any]]
#: A point or a vector: two numbers, of solids three.
Vector = Union[Sequence[float], npt.NDArray[Any]]
#: A rotation or a moment: a number, of solids three.
Spin = Union[float, Vector]
#: A number, an expression in ``x``, ``y`` and of solids ``z``; in the plane also an array with a value at each node of the body's
#: mesh, or a function of the two coordinates, which is called once with arrays.
Datum = Union[float, str, npt.ArrayLike, Function]


def is_masked(value: Any) -> bool:
    """Say whether an array, or an array in a sequence, has a mask: what it hides would be used as if it were not hidden."""
    if isinstance(value, (list, tuple)):
        return any(is_masked(entry) for entry in value)
    return isinstance(value, np.ma.MaskedArray)


def fixed(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Make an array of results read-only."""
    array.flags.writeable = False
    return array


def _array(value: Any, what: str, kinds: str, expected: str) -> npt.NDArray[Any]:
    if is_masked(value):
        refuse(what, "a masked array", expected, "fill it with numbers first, such as by filled(0.0)")
    try:
        array = np.asarray(value)
    except (TypeError, ValueError) as error:
        refuse(what, f"it cannot be made an array: {error}", expected, "check its shape")
    if array.dtype.kind not in kinds and array.size > 0:
        refuse(what, f"an array of type {array.dtype}", expected, "convert it first")
    return array


def floats(value: Any, what: str, *shapes: tuple[Optional[int], ...]) -> Floats:
    """Make a contiguous array of finite numbers of one of some shapes; `None` is any length."""
    expected = f"finite real numbers, shape {' or '.join(_shown(shape) for shape in shapes)}"
    array = _array(value, what, "fiu", expected)
    if not any(_fits(array.shape, shape) for shape in shapes):
        refuse(what, f"the shape is {array.shape}", expected, "check rows and columns")
    made = np.ascontiguousarray(array, dtype=np.float64)
    if not np.isfinite(made).all():
        place = tuple(int(k) for k in np.argwhere(~np.isfinite(made))[0])
        index = place[0] if len(place) == 1 else place
        refuse(what, f"the value at {index} is {made[place]}", expected, "take out what is not finite")
    return made


def integers(value: Any, what: str, shape: tuple[Optional[int], ...]) -> Integers:
    """Make a contiguous array of numbers of nodes or triangles, counted from 0."""
    expected = f"whole numbers >= 0, shape {_shown(shape)}"
    array = _array(value, what, "iu", expected)
    if array.size == 0 and len(shape) == 2 and array.ndim < 2:
        array = array.reshape(0, shape[1] or 0)
    if not _fits(array.shape, shape):
        refuse(what, f"the shape is {array.shape}", expected, "check rows and columns")
    made = np.ascontiguousarray(array, dtype=np.int64)
    if made.size > 0 and made.min() < 0:
        refuse(what, f"the number {made.min()}", expected, "count from 0")
    return made


def evaluated(key: str, function: Function, x: Floats, y: Floats) -> Floats:
    """Call a function with the coordinates of nodes; what it raises passes through."""
    value = of_caller(function)(x, y)
    expected = f"one finite number for each of the {x.size} nodes"
    array = _array(value, f"{key}: the function's result", "fiu", expected)
    if array.shape not in ((), x.shape):
        refuse(key, f"the function returns the shape {array.shape}", expected, "use functions of NumPy, such as np.sin")
    made = np.ascontiguousarray(np.broadcast_to(array, x.shape), dtype=np.float64)
    if not np.isfinite(made).all():
        k = int(np.argmin(np.isfinite(made)))
        refuse(key, f"the function is {made[k]} at ({x[k]}, {y[k]})", expected, "change it at this place")
    return made


def _fits(found: tuple[int, ...], shape: tuple[Optional[int], ...]) -> bool:
    return len(found) == len(shape) and all(n in (None, m) for n, m in zip(shape, found))


def _shown(shape: tuple[Optional[int], ...]) -> str:
    words = ["n" if length is None else str(length) for length in shape]
    return f"({words[0]},)" if len(words) == 1 else f"({', '.join(words)})"
