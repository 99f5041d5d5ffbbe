"""Problems made of objects: each writes the keys of the case file that it is about."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, TypedDict, Union

import numpy.typing as npt

from ._case import Progress, native
from ._data import Datum, Pair, Spin, Vector, floats
from ._errors import refuse
from ._mesh import Mesh
from ._solution import Check, Solution, Sweep, check, solve, sweep

if TYPE_CHECKING:
    from typing_extensions import Unpack

Sides = Union[str, Sequence[str]]
Range = Mapping[str, Pair]


class Motion(TypedDict, total=False):
    """Motion and load of an obstacle."""

    ux: float
    uy: float
    uz: float
    rotation: Spin
    force: Vector
    moment: Spin
    about: Vector


class Material:
    """An elastic material.

    Parameters
    ----------
    young : float
        Young's modulus, Pa.
    poisson : float
        Poisson's ratio.
    name : str, optional
        Its name in messages and reports.

    Examples
    --------
    >>> Material(210e9, 0.3, name="steel")
    Material(young=210000000000.0, poisson=0.3)
    """

    def __init__(self, young: float, poisson: float, *, name: Optional[str] = None) -> None:
        self.name = name
        self._keys: dict[str, Any] = {"young": young, "poisson": poisson}

    def having(
        self,
        *,
        expansion: Optional[float] = None,
        density: Optional[float] = None,
        limit: Optional[float] = None,
    ) -> Material:
        """Return the material with further constants.

        Parameters
        ----------
        expansion : float, optional
            Strain per unit of temperature, the same in all directions.
        density : float, optional
            Mass per volume, kg/m³: for `rotation` and `acceleration` of a `Problem`.
        limit : float, optional
            The equivalent stress that it may bear, Pa: a note says how much of it the largest recovered stress is.
        """
        given = {"expansion": expansion, "density": density, "limit": limit}
        return Material._of(self.name, {**self._keys, **{key: value for key, value in given.items() if value is not None}})

    @classmethod
    def _of(cls, name: Optional[str], keys: dict[str, Any]) -> Material:
        made = cls.__new__(cls)
        made.name, made._keys = name, keys
        return made

    @classmethod
    def orthotropic(
        cls,
        young_1: float,
        young_2: float,
        poisson_12: float,
        shear: Optional[float] = None,
        *,
        angle: Optional[float] = None,
        young_3: Optional[float] = None,
        poisson_13: Optional[float] = None,
        poisson_23: Optional[float] = None,
        shear_12: Optional[float] = None,
        shear_13: Optional[float] = None,
        shear_23: Optional[float] = None,
        axes: Optional[npt.ArrayLike] = None,
        name: Optional[str] = None,
    ) -> Material:
        """Make an orthotropic material.

        Parameters
        ----------
        young_1, young_2, young_3 : float
            Moduli along the axes, Pa; the third one for plane strain and solids.
        poisson_12, poisson_13, poisson_23 : float
            Poisson's ratios; the last two for plane strain and solids.
        shear : float
            In the plane: shear modulus, Pa.
        angle : float, optional
            In the plane: from x to the first axis, degrees; 0 by default.
        shear_12, shear_13, shear_23 : float
            Of solids: shear moduli, Pa.
        axes : (2, 3) array_like
            Of solids: vectors along axes 1 and 2.
        name : str, optional
            Its name.
        """
        keys = {
            "young_1": young_1,
            "young_2": young_2,
            "poisson_12": poisson_12,
            "shear": shear,
            "angle": angle,
            "young_3": young_3,
            "poisson_13": poisson_13,
            "poisson_23": poisson_23,
            "shear_12": shear_12,
            "shear_13": shear_13,
            "shear_23": shear_23,
            "axes": None if axes is None else floats(axes, "axes", (2, 3)),
        }
        return cls._of(name, keys)

    @classmethod
    def of_stiffness(cls, stiffness: npt.ArrayLike, *, name: Optional[str] = None) -> Material:
        """Make a material of the stiffness of the plane problem, or of a solid.

        Parameters
        ----------
        stiffness : (3, 3) or (6, 6) array_like
            From the strains (xx, yy, 2 xy) to the stresses (xx, yy, xy), Pa; of solids from (xx, yy, zz, 2 yz, 2 xz, 2 xy) to
            (xx, yy, zz, yz, xz, xy).
        name : str, optional
            Its name.
        """
        return cls._of(name, {"stiffness": floats(stiffness, "stiffness", (3, 3), (6, 6))})

    def __repr__(self) -> str:
        given = ", ".join(f"{key}={value}" for key, value in self._keys.items() if value is not None)
        return f"Material({given})"


class Body:
    """A body: mesh, material, supports and loads. Its methods return the body, so that they can be chained.

    A body of tetrahedra is a solid: its vectors have three numbers, and its data are numbers or expressions. Sides that are not
    named are free. A `part` is ``{"x": (low, high)}``, also with ``"y"`` and ``"z"``: only the edges or faces within count. A
    `name` of a condition is what load steps call it.

    Parameters
    ----------
    mesh : Mesh
        Its mesh.
    material : Material
        Its material.
    name : str, optional
        Its name in messages, reports and files.
    region : str or sequence of str, optional
        The regions of the mesh that it is made of; all cells by default.
    body_force : (2,) or (3,) array_like or expressions, optional
        Force per volume, N/m³.
    merge : bool
        Whether nodes at one place become one node.
    duplicate_interface : bool
        Whether two bodies of one mesh may share nodes; each gets its own.

    Examples
    --------
    >>> mesh = Mesh.block((0, 0), (1, 1), (4, 4))
    >>> Body(mesh, Material(1000.0, 0.3), name="cube").fix("bottom").displace("top", uy=-0.1).load("right", (0, 30))
    <Body cube: 25 nodes, 2 supports, 1 load>
    """

    def __init__(
        self,
        mesh: Mesh,
        material: Material,
        name: Optional[str] = None,
        *,
        region: Optional[Sides] = None,
        body_force: Optional[Vector] = None,
        merge: bool = False,
        duplicate_interface: bool = False,
    ) -> None:
        if not isinstance(mesh, Mesh):
            refuse("mesh", f"an object of type {type(mesh).__name__}", "a Mesh", "make one, or read it with Mesh.read")
        if not isinstance(material, Material):
            refuse("material", f"an object of type {type(material).__name__}", "a Material", "write Material(young, poisson)")
        self.mesh = mesh
        self.material = material
        self.name = name
        self._region = region
        self._body_force = body_force
        self._options = {"merge": merge or None, "duplicate_interface": duplicate_interface or None}
        self._lists: dict[str, list[dict[str, Any]]] = {}

    def _add(self, table: str, **keys: Any) -> Body:
        self._lists.setdefault(table, []).append(keys)
        return self

    def fix(self, on: Sides, *, part: Optional[Range] = None, name: Optional[str] = None) -> Body:
        """Hold all components of a side.

        Parameters
        ----------
        on : str or sequence of str
            The side, or several.
        part, name : optional
            See `Body`.
        """
        return self._add("displacement", name=name, on=on, part=part, fixed=True)

    def displace(
        self,
        on: Sides,
        *,
        ux: Optional[Datum] = None,
        uy: Optional[Datum] = None,
        uz: Optional[Datum] = None,
        normal: Optional[Datum] = None,
        part: Optional[Range] = None,
        name: Optional[str] = None,
    ) -> Body:
        """Impose displacements on a side; components that are not given are free.

        Parameters
        ----------
        on : str or sequence of str
            The side, or several.
        ux, uy, uz : number, expression, (n,) array or function, optional
            Components, m; `uz` of solids.
        normal : number, expression, (n,) array or function, optional
            Instead, the component along the outward normal, m: 0 is a roller.
        part, name : optional
            See `Body`.
        """
        return self._add("displacement", name=name, on=on, part=part, ux=ux, uy=uy, uz=uz, normal=normal)

    def warm(self, value: Union[float, str], *, name: Optional[str] = None) -> Body:
        """Change the temperature; several changes add up.

        Parameters
        ----------
        value : float or str
            The change, a number or an expression.
        name : str, optional
            See `Body`.
        """
        return self._add("temperature", name=name, value=value)

    def load(
        self,
        on: Sides,
        vector: Optional[Union[Sequence[Datum], npt.NDArray[Any]]] = None,
        *,
        pressure: Optional[Datum] = None,
        part: Optional[Range] = None,
        name: Optional[str] = None,
    ) -> Body:
        """Load a side.

        Parameters
        ----------
        on : str or sequence of str
            The side, or several.
        vector : two of number, expression, (n,) array or function; or (n, 2) array; optional
            Traction, Pa. Of solids three of number or expression.
        pressure : number, expression, (n,) array or function, optional
            Instead, a pressure onto the body, Pa.
        part, name : optional
            See `Body`.
        """
        return self._add("traction", name=name, on=on, part=part, vector=vector, pressure=pressure)

    def rigid(
        self,
        on: Sides,
        *,
        ux: Optional[float] = None,
        uy: Optional[float] = None,
        uz: Optional[float] = None,
        rotation: Optional[Spin] = None,
        force: Optional[Vector] = None,
        moment: Optional[Spin] = None,
        about: Optional[Vector] = None,
        part: Optional[Range] = None,
        name: Optional[str] = None,
    ) -> Body:
        """Keep a side rigid; what is neither imposed nor loaded is free.

        Parameters
        ----------
        on : str or sequence of str
            The side, or several.
        ux, uy, uz : float, optional
            Imposed motion of the point `about`, m; `uz` of solids.
        rotation : float, of solids (3,) array_like, optional
            Imposed rotation, radians.
        force : (2,) or (3,) array_like, optional
            Resultant, N/m, of solids N.
        moment : float, of solids (3,) array_like, optional
            Moment about `about`, N, of solids N m.
        about : (2,) or (3,) array_like, optional
            A point, m; the centroid of the side by default.
        part, name : optional
            See `Body`.
        """
        keys = {"ux": ux, "uy": uy, "uz": uz, "rotation": rotation, "force": force, "moment": moment, "about": about}
        return self._add("rigid", name=name, on=on, part=part, **keys)

    def spring(
        self,
        on: Sides,
        stiffness: Datum,
        *,
        along: Optional[Union[str, Vector]] = None,
        rest: Optional[Union[Datum, Sequence[Datum]]] = None,
        part: Optional[Range] = None,
        name: Optional[str] = None,
    ) -> Body:
        """Put springs between a side and the ground.

        Parameters
        ----------
        on : str or sequence of str
            The side, or several.
        stiffness : number, expression, (n,) array or function
            Traction per displacement, Pa/m: constant on each edge or face, its value in the middle.
        along : {"normal", "all"} or (2,) or (3,) array_like, optional
            The directions of the springs; the normal by default.
        rest : number or expression, or one for each component, optional
            The displacement at which they are relaxed, m; 0 by default.
        part, name : optional
            See `Body`.
        """
        return self._add("spring", name=name, on=on, part=part, stiffness=stiffness, along=along, rest=rest)

    def cut(
        self,
        name: str,
        point: Vector,
        normal: Vector,
        *,
        shortening: Optional[float] = None,
        force: Optional[float] = None,
        box: Optional[Range] = None,
    ) -> Body:
        """Tighten a bolt: cut it along edges or faces of the mesh, and draw it together.

        Parameters
        ----------
        name : str
            Its name in `results.cuts` of the report; load steps scale it by this name.
        point, normal : (2,) or (3,) array_like
            The plane of the cut, m.
        shortening : float, optional
            By which the bolt is drawn together, m.
        force : float, optional
            The force in the bolt instead, N/m, of solids N; it pulls if it is positive.
        box : dict, optional
            The part of the plane, such as `{"x": (0, 1)}`.
        """
        plane = {"point": point, "normal": normal}
        return self._add("cut", name=name, plane=plane, box=box, shortening=shortening, force=force)

    def curve(self, on: Sides, kind: str) -> Body:
        """Say that new nodes of a side on finer meshes lie on a curve, in the plane.

        Parameters
        ----------
        on : str or sequence of str
            The side, or several.
        kind : {"arc", "smooth"}
            A circle through its nodes, or a smooth curve.
        """
        return self._add("curve", on=on, kind=kind)

    def surface(self, on: Sides, kind: str) -> Body:
        """Say that a side of a solid lies on a surface: new nodes on finer meshes lie on it, and contact has its normals.

        Parameters
        ----------
        on : str or sequence of str
            The side, or several.
        kind : {"plane", "cylinder", "sphere"}
            The surface through its nodes.
        """
        return self._add("surface", on=on, kind=kind)

    def side(
        self,
        name: str,
        *,
        box: Optional[Range] = None,
        facing: Optional[Vector] = None,
        within: Optional[float] = None,
        circle: Optional[tuple[Vector, float]] = None,
        sphere: Optional[tuple[Vector, float]] = None,
        cylinder: Optional[tuple[Vector, Vector, float]] = None,
        point: Optional[Vector] = None,
    ) -> Body:
        """Name the boundary edges or faces at some place; all conditions that are given count.

        Parameters
        ----------
        name : str
            The name.
        box : mapping, optional
            All corners lie in ``{"x": (low, high), "y": (low, high)}``, of solids also ``"z"``, m.
        facing : (2,) or (3,) array_like, optional
            A direction of the outward normal.
        within : float, optional
            The angle from it, at most, degrees; 30 by default.
        circle, sphere : (centre, radius), optional
            All corners lie on it, m: a circle in the plane, of solids a sphere.
        cylinder : (point, axis, radius), optional
            All corners of solids lie on it, m: a point of its axis, the direction of its axis, and its radius.
        point : (2,) or (3,) array_like, optional
            Instead of these, the boundary node there, for `fix` and `displace`.
        """
        round_ = {"circle": circle, "sphere": sphere}
        on = {key: given and {"centre": given[0], "radius": given[1]} for key, given in round_.items()}
        on["cylinder"] = cylinder and {"point": cylinder[0], "axis": cylinder[1], "radius": cylinder[2]}
        return self._add("side", name=name, box=box, facing=facing, within=within, **on, point=point)

    def region(self, material: Material, *, group: Optional[str] = None, box: Optional[Range] = None) -> Body:
        """Give a part of the body another material.

        Parameters
        ----------
        material : Material
            The material.
        group : str, optional
            A region of the mesh.
        box : mapping, optional
            Instead, the cells with their centroids in ``{"x": (low, high), "y": (low, high)}``, of solids also ``"z"``, m.
        """
        return self._add("region", material=material, group=group, box=box)

    def __repr__(self) -> str:
        supports, loads = (len(self._lists.get(kind, [])) for kind in ("displacement", "traction"))
        words = [f"{count} {what}{'' if count == 1 else 's'}" for count, what in ((supports, "support"), (loads, "load"))]
        return f"<Body {self.name or '(without a name)'}: {len(self.mesh.points)} nodes, {', '.join(words)}>"


class Obstacle:
    """A rigid line or surface that a body touches.

    Make it with `plane` or `circle`, for solids with `plane`, `sphere` or `cylinder`. It is fixed, unless one of these
    arguments is given; what is then neither imposed nor loaded is free.

    - `ux`, `uy`, of solids `uz`: imposed motion, m
    - `rotation`: imposed rotation, radians; of solids (3,) array_like
    - `force`: (2,) array_like, N/m; of solids (3,) array_like, N
    - `moment`: N; of solids (3,) array_like, N m
    - `about`: (2,) or (3,) array_like, the point about which it rotates, m
    """

    def __init__(self, keys: dict[str, Any]) -> None:
        self._keys = keys

    @classmethod
    def plane(cls, point: Vector, normal: Vector, **motion: Unpack[Motion]) -> Obstacle:
        """Make a straight line, of solids a plane.

        Parameters
        ----------
        point, normal : (2,) or (3,) array_like
            A point of it, m, and its normal out of the obstacle.
        **motion
            See `Obstacle`.
        """
        return cls({"kind": "plane", "point": point, "normal": normal, **motion})

    @classmethod
    def circle(cls, centre: Vector, radius: float, *, side: str = "outside", **motion: Unpack[Motion]) -> Obstacle:
        """Make a circle, in the plane.

        Parameters
        ----------
        centre, radius : (2,) array_like and float
            m.
        side : {"outside", "inside"}
            On which side of it the body is.
        **motion
            See `Obstacle`.
        """
        return cls({"kind": "circle", "centre": centre, "radius": radius, "side": side, **motion})

    @classmethod
    def sphere(cls, centre: Vector, radius: float, *, side: str = "outside", **motion: Unpack[Motion]) -> Obstacle:
        """Make a sphere, for solids.

        Parameters
        ----------
        centre, radius : (3,) array_like and float
            m.
        side : {"outside", "inside"}
            On which side of it the body is.
        **motion
            See `Obstacle`.
        """
        return cls({"kind": "sphere", "centre": centre, "radius": radius, "side": side, **motion})

    @classmethod
    def cylinder(cls, point: Vector, axis: Vector, radius: float, *, side: str = "outside", **motion: Unpack[Motion]) -> Obstacle:
        """Make a cylinder without ends, for solids.

        Parameters
        ----------
        point, axis : (3,) array_like
            A point of its axis, m, and the direction of its axis.
        radius : float
            m.
        side : {"outside", "inside"}
            On which side of it the body is.
        **motion
            See `Obstacle`.
        """
        return cls({"kind": "cylinder", "point": point, "axis": axis, "radius": radius, "side": side, **motion})

    def __repr__(self) -> str:
        given = ", ".join(f"{key}={value!r}" for key, value in self._keys.items() if value is not None)
        return f"Obstacle({given})"


class Friction:
    """A law of friction. Make it with `tresca` or `coulomb`."""

    def __init__(self, keys: dict[str, Any]) -> None:
        self._keys = keys

    @classmethod
    def tresca(cls, limit: Datum) -> Friction:
        """Resist up to a given limit, also on open contact; solutions are certified.

        Parameters
        ----------
        limit : number, expression, (n,) array or function
            Largest traction along the contact line, Pa. An array has a value at each node of the first body's mesh.
        """
        return cls({"law": "tresca", "limit": limit})

    @classmethod
    def coulomb(cls, mu: float) -> Friction:
        """Resist up to `mu` times the pressure. No bound of the error is known for this law.

        Parameters
        ----------
        mu : float
            The coefficient.
        """
        return cls({"law": "coulomb", "mu": mu})

    def __repr__(self) -> str:
        return f"Friction({', '.join(f'{key}={value!r}' for key, value in self._keys.items())})"


class Contact:
    """Two sides that may touch, or hang together.

    Parameters
    ----------
    first : Body
        A body.
    second : Body or Obstacle
        Another body, or a rigid line or surface.
    surfaces : str or sequence
        A side of each of the bodies; each may be a list of sides.
    gap : number, expression, (n,) array, function or "geometric", optional
        Initial gap, m, negative for an interference: an array has a value at each node of the first body's mesh; "geometric" is
        measured between the meshes. By default the surfaces must touch.
    interference : bool, optional
        Keeps a drawn overlap as a negative gap, which is then measured.
    friction : Friction, optional
        The law; by default the surfaces slide freely.
    law : {"unilateral", "bonded"}, optional
        Whether the sides touch and part, the default, or hang together.
    offset : (2,) or (3,) array_like, optional
        Of a bonded pair: the displacement of the first body less that of the second, m.
    normal : (2,) array_like, optional
        One direction of contact, out of the first body, in the plane; averaged at the nodes by default.
    direction : (3,) array_like, optional
        Of solids: along which surfaces that do not match are laid over each other; their mean normal by default.
    imposed : {"first", "second", "auto"}, optional
        The body of this pair that carries λ.
    motion : (2,) or (3,) array_like, optional
        Moves the obstacle, m.
    name : str, optional
        Its name in messages, reports and files.
    """

    def __init__(
        self,
        first: Body,
        second: Union[Body, Obstacle],
        surfaces: Union[str, Sequence[Sides]],
        *,
        gap: Optional[Datum] = None,
        interference: bool = False,
        friction: Optional[Friction] = None,
        law: Optional[str] = None,
        offset: Optional[Vector] = None,
        normal: Optional[Pair] = None,
        direction: Optional[Vector] = None,
        imposed: Optional[str] = None,
        motion: Optional[Vector] = None,
        name: Optional[str] = None,
    ) -> None:
        for body in (first, second):
            if not isinstance(body, (Body, Obstacle)):
                refuse("contact", f"an object of type {type(body).__name__}", "a Body or an Obstacle", "check the arguments")
        if friction is not None and not isinstance(friction, Friction):
            fix = "write Friction.coulomb(mu) or Friction.tresca(limit)"
            refuse("friction", f"an object of type {type(friction).__name__}", "a Friction", fix)
        self.first = first
        self.second = second
        self.surfaces = [surfaces] if isinstance(surfaces, str) else list(surfaces)
        self.friction = friction
        self.name = name
        self._keys: dict[str, Any] = {
            "gap": gap,
            "interference": interference or None,
            "law": law,
            "offset": offset,
            "normal": normal,
            "direction": direction,
            "imposed": imposed,
            "motion": motion,
        }

    def _table(self, names: Mapping[int, str]) -> dict[str, Any]:
        members = [body for body in (self.first, self.second) if isinstance(body, Body)]
        for body in members:
            if id(body) not in names:
                refuse(
                    "contact", f"{body!r} is not a body of the problem", "bodies of the problem", "add it to the list of bodies"
                )
        return {
            "name": self.name,
            "bodies": [names[id(body)] for body in members],
            "surfaces": self.surfaces,
            "obstacle": self.second._keys if isinstance(self.second, Obstacle) else None,
            "friction": self.friction._keys if self.friction else None,
            **self._keys,
        }

    def __repr__(self) -> str:
        return f"<Contact of {self.first!r} and {self.second!r}>"


class Step:
    """A load step: factors of named conditions at its end.

    Parameters
    ----------
    factors : mapping of str to float
        What the conditions of these names are multiplied by; other names keep their factors.
    count : int
        Equal increments, each with a result and a certificate of its own.
    """

    def __init__(self, factors: Mapping[str, float], count: int = 1) -> None:
        self.factors = dict(factors)
        self.count = count

    def __repr__(self) -> str:
        return f"Step({self.factors}, count={self.count})"


class Problem:
    """A contact problem, of the plane or of solids.

    Parameters
    ----------
    bodies : iterable of Body
        The bodies, all of triangles or all of tetrahedra; those without a name are called body1, body2, …
    contacts : iterable of Contact
        The pairs; may be empty.
    steps : iterable of Step
        Load steps; one step from rest by default.
    hypothesis : {"plane_strain", "plane_stress"}, optional
        How the third direction of the plane behaves; plane strain by default.
    thickness : float, optional
        Of the plane, m; it only converts results in report.html.
    rotation : mapping, optional
        ``{"speed": 100.0, "point": (0, 0)}``, of solids with ``"axis"``: all bodies turn, radians per unit of time.
    acceleration : (2,) or (3,) array_like, optional
        Force per mass on all bodies, such as gravity, m/s².
    title : str, optional
        One line.
    units : (length, force), optional
        Names for labels, such as ``("mm", "N")``; no number changes.

    Examples
    --------
    >>> steel = Material(1000.0, 0.3)
    >>> lower = Body(Mesh.block((0, 0), (2, 1), (6, 3)), steel, "lower").fix("bottom")
    >>> upper = Body(Mesh.block((0, 1), (2, 1), (6, 3)), steel, "upper").displace("top", ux=0.0, uy=-0.01)
    >>> problem = Problem([upper, lower], [Contact(upper, lower, ("bottom", "top"))])
    >>> solution = problem.solve(threads=1)
    >>> solution.status, solution.valid
    ('converged', True)
    """

    def __init__(
        self,
        bodies: Iterable[Body],
        contacts: Iterable[Contact] = (),
        *,
        steps: Iterable[Step] = (),
        hypothesis: Optional[str] = None,
        thickness: Optional[float] = None,
        rotation: Optional[Mapping[str, Any]] = None,
        acceleration: Optional[Vector] = None,
        title: Optional[str] = None,
        units: Optional[tuple[str, str]] = None,
    ) -> None:
        self.bodies = list(bodies)
        self.contacts = list(contacts)
        self.steps = list(steps)
        self.hypothesis = hypothesis
        self.thickness = thickness
        self.rotation = rotation
        self.acceleration = acceleration
        self.title = title
        self.units = units

    def to_dict(self) -> dict[str, Any]:
        """Return the keys of the case file, with meshes, arrays and functions as they are."""
        names = {id(body): body.name or f"body{k}" for k, body in enumerate(self.bodies, 1)}
        materials: dict[str, Material] = {}

        def of(material: Material) -> str:
            """Name a material; the same object has the same name."""
            for name, other in materials.items():
                if other is material:
                    return name
            name = material.name or f"material{len(materials) + 1}"
            while name in materials:
                name += "'"
            materials[name] = material
            return name

        def table(body: Body) -> dict[str, Any]:
            mesh = body.mesh
            lists = {kind: [dict(entry) for entry in entries] for kind, entries in body._lists.items()}
            made: dict[str, Any] = {"name": names[id(body)], "material": of(body.material)}
            if mesh._generator is not None and body._region is None:
                made["generator"] = mesh._generator
            else:
                made["mesh"] = {"file": mesh, "region": body._region, **body._options}
            for region in lists.get("region", []):
                region["material"] = of(region["material"])
            return {**made, "body_force": body._body_force, **lists}

        bodies = [table(body) for body in self.bodies]
        units = None if self.units is None else {"length": self.units[0], "force": self.units[1]}
        return {
            "schema": 1,
            "title": self.title,
            "units": units,
            "model": {
                "hypothesis": self.hypothesis,
                "thickness": self.thickness,
                "rotation": None if self.rotation is None else dict(self.rotation),
                "acceleration": self.acceleration,
            },
            "materials": {name: material._keys for name, material in materials.items()},
            "body": bodies,
            "contact": [contact._table(names) for contact in self.contacts],
            "step": [{"factors": step.factors, "count": step.count} for step in self.steps] or None,
        }

    def solve(
        self,
        target: Optional[float] = None,
        *,
        on_iteration: Optional[Progress] = None,
        threads: Optional[int] = None,
        **overrides: Any,
    ) -> Solution:
        """Solve and certify.

        Parameters
        ----------
        target : float, optional
            Refine the meshes until this relative error is certified, such as 0.02. With Coulomb friction it is the relative
            residual, which bounds no error.
        on_iteration, threads, **overrides
            See `nndd.solve`.

        Returns
        -------
        Solution
            What was found, however the run ended.
        """
        if target is not None:
            laws = [contact.friction._keys["law"] for contact in self.contacts if contact.friction]
            key = "target_coulomb_residual" if "coulomb" in laws else "target_relative_error"
            overrides = {f"adapt.{key}": target, **overrides}
        return solve(self, on_iteration=on_iteration, threads=threads, **overrides)

    def check(self, *, threads: Optional[int] = None, **overrides: Any) -> Check:
        """Check everything that needs no factorisation; see `nndd.check`."""
        return check(self, threads=threads, **overrides)

    def sweep(self, over: str, **options: Any) -> Sweep:
        """Compare values of one setting; see `nndd.sweep`."""
        return sweep(self, over, **options)

    def mesh(self, body: int) -> Mesh:
        """Return the mesh of a body as it is computed with: without unused nodes, with the sides of `Body.side`."""
        return Mesh._of(native(self).mesh(body))

    def __repr__(self) -> str:
        return f"<Problem: {len(self.bodies)} bodies, {len(self.contacts)} contacts>"
