"""Contact between elastic bodies of the plane or solid ones, with a guaranteed bound of the error.

Three levels: `solve`, `check` and `sweep` take a case file or a dict of the same keys; `Problem` and its parts make the keys of
objects and arrays; `certify` bounds the error of a field from anywhere. Results are arrays of NumPy.

>>> import nndd
>>> solution = nndd.solve("tests/cases/paper.toml")
>>> print(f"{solution.status}: certified error <= {100 * solution.relative:.1f} %")
converged: certified error <= 18.8 %
"""

from ._errors import CaseWarning, Error, FileError, InvalidInput, LimitReached, NotSolvable
from ._mesh import Mesh
from ._model import Body, Contact, Friction, Material, Obstacle, Problem, Step
from ._nndd import __version__
from ._plot import Picture
from ._results import BodyResult, ContactResult
from ._solution import Certificate, Check, Solution, Status, Sweep, certify, check, solve, sweep

__all__ = [
    "Body",
    "BodyResult",
    "CaseWarning",
    "Certificate",
    "Check",
    "Contact",
    "ContactResult",
    "Error",
    "FileError",
    "Friction",
    "InvalidInput",
    "LimitReached",
    "Material",
    "Mesh",
    "NotSolvable",
    "Obstacle",
    "Picture",
    "Problem",
    "Solution",
    "Status",
    "Step",
    "Sweep",
    "__version__",
    "certify",
    "check",
    "solve",
    "sweep",
]
