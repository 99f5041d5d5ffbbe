#!/usr/bin/env python3
"""Tries `nndd check` on every mesh file (.msh, .inp) of some repositories.

    python3 public_meshes.py --nndd target/release/nndd --work runs/meshes --out bench-results/meshes \
        mfem/mfem=CHECKOUT dealii/dealii=CHECKOUT ...

Each argument is a repository's name and a folder with its files. Files with the same contents count once, for the
repository that is named first. A reader of its own, below, says which files are plane meshes, and what they must hold;
it shares no code with nndd. Needs Python 3 and nothing else. Writes meshes.csv to --out; case files and copies of the meshes stay in --work.
"""

import argparse
import csv
import hashlib
import json
import re
import struct
import subprocess
import sys
from collections import Counter, defaultdict
from pathlib import Path

# Gmsh's element types: dimension, corners, nodes.
GMSH = {1: (1, 2, 2), 2: (2, 3, 3), 3: (2, 4, 4), 4: (3, 4, 4), 5: (3, 8, 8), 6: (3, 6, 6), 7: (3, 5, 5), 8: (1, 2, 3),
        9: (2, 3, 6), 10: (2, 4, 9), 11: (3, 4, 10), 12: (3, 8, 27), 13: (3, 6, 18), 14: (3, 5, 14), 15: (0, 1, 1),
        16: (2, 4, 8), 17: (3, 8, 20), 18: (3, 6, 15), 19: (3, 5, 13), 20: (2, 3, 9), 21: (2, 3, 10), 22: (2, 3, 12),
        23: (2, 3, 15), 24: (2, 3, 15), 25: (2, 3, 21), 26: (1, 2, 4), 27: (1, 2, 5), 28: (1, 2, 6), 29: (3, 4, 20),
        30: (3, 4, 35), 31: (3, 4, 56), 36: (2, 4, 16), 37: (2, 4, 25), 38: (2, 4, 36), 39: (2, 4, 12), 40: (2, 4, 16),
        41: (2, 4, 20), 92: (3, 8, 64), 93: (3, 8, 125), 133: (0, 1, 1), 134: (1, 2, 2), 135: (2, 3, 3), 136: (3, 4, 4)}


# Reasons of refusal: what the message says, what it is called here, whether the owner of the file can act on it.
REASONS = [
    (r"this is MSH version 3", "MSH 3, never released: Gmsh converts it, but to an element type that is not read", False),
    (r"the dimension of a group is", "a group of dimension -1, which Gmsh does not read either", False),
    (r"AVS UCD", "AVS UCD: the help names the conversion by meshio", True),
    (r"mesh of FreeFem", "FreeFem: the help names the conversion", True),
    (r"mesh of GiD", "GiD: the help says how to write it as a deck", True),
    (r"axisymmetric", "axisymmetric elements: no plane problem", True),
    (r"\*PART is not read", "parts and instances of Abaqus/CAE: export without, or convert", True),
    (r"higher-order", "elements of third order: mesh again with order 1", True),
    (r"is given twice", "an element number twice", True),
    (r"has 0 coordinates", "a node without coordinates", True),
    (r"overlap at", "parts that overlap and have no groups by which one could be chosen", True),
    (r"crosses itself", "a cell that crosses itself", True),
    (r"which the deck does not have", "a set names a node that is not there", True),
]


def reason(message):
    return next(((label, clear) for sign, label, clear in REASONS if re.search(sign, message)), ("other", False))


class Mesh:
    """Nodes, and elements as (dimension, corners, groups)."""

    def __init__(self, form):
        self.form, self.nodes, self.elements, self.odd = form, {}, [], ""
        self.order = 1

    def add(self, dimension, corners, groups=()):
        self.elements.append((dimension, tuple(corners), tuple(groups)))


def gmsh(data):
    sections, at = {}, 0
    head = re.match(rb"(?:\s*\$Comments.*?\$EndComments)?\s*\$(MeshFormat|NOD)", data, re.S)
    if head[1] == b"NOD":
        return gmsh1(data)
    values = re.search(rb"\$MeshFormat\s+(\S+)\s+(\d)\s+(\d+)", data)
    version, binary = float(values[1]), values[2] == b"1"
    mesh = Mesh(f"MSH {version:g}" + (", binary" if binary else ""))
    if binary:
        return gmsh_binary(data, version, mesh)
    lines = [line.strip() for line in data.decode("latin-1").splitlines()]
    k = 0
    while k < len(lines):
        if lines[k].startswith("$") and not lines[k].startswith("$End"):
            name, start = lines[k][1:], k + 1
            while k < len(lines) and lines[k] != "$End" + name:
                k += 1
            sections.setdefault(name, [line for line in lines[start:k] if line])
        k += 1
    names = {}
    for line in sections.get("PhysicalNames", ["0"])[1:]:
        found = re.match(r'(\d+)\s+(-?\d+)\s+"(.*)"', line)
        if found:
            names[int(found[1]), abs(int(found[2]))] = found[3].strip()
    call = lambda d, tag: names.get((d, abs(tag)), str(abs(tag)))
    if version < 4:
        for line in sections["Nodes"][1:]:
            f = line.split()
            mesh.nodes[int(f[0])] = tuple(map(float, f[1:4]))
        for line in sections["Elements"][1:]:
            f = list(map(int, line.split()))
            d, corners, nodes = GMSH[f[1]]
            mesh.order = max(mesh.order, 1 + (nodes > corners))
            if version == 3:
                mesh.add(d, f[4:4 + corners])
                continue
            tags = f[3:3 + f[2]]
            mesh.add(d, f[3 + f[2]:][:corners], [call(d, tags[0])] if tags and tags[0] else [])
        return mesh
    groups = {}
    for section in ("Entities", "PartitionedEntities"):
        rows = [line.split() for line in sections.get(section, [])]
        if not rows:
            continue
        k = 0
        parted = section != "Entities"
        if parted:
            ghosts = int(rows[1][0])
            k = 2 + (ghosts if len(rows[1]) == 1 else 0)
        counts, k = list(map(int, rows[k])), k + 1
        for d, count in enumerate(counts):
            for row in rows[k:k + count]:
                p = 1
                if parted:
                    p += 2
                    p += 1 + int(row[p])
                # Version 4.0 gives six numbers for points too.
                p += 3 if d == 0 and version > 4.05 else 6
                n = int(row[p])
                groups[d, int(row[0])] = [call(d, int(tag)) for tag in row[p + 1:p + 1 + n]]
            k += count
    rows = [line.split() for line in sections["Nodes"]]
    k = 1
    while k < len(rows):
        n = int(rows[k][3])
        if version < 4.05:
            for row in rows[k + 1:k + 1 + n]:
                mesh.nodes[int(row[0])] = tuple(map(float, row[1:4]))
            k += 1 + n
        else:
            for number, row in zip(rows[k + 1:k + 1 + n], rows[k + 1 + n:k + 1 + 2 * n]):
                mesh.nodes[int(number[0])] = tuple(map(float, row[:3]))
            k += 1 + 2 * n
    rows = [list(map(int, line.split())) for line in sections["Elements"]]
    k = 1
    while k < len(rows):
        a, b, code, n = rows[k]
        d, entity = (b, a) if version < 4.05 else (a, b)
        d, corners, nodes = GMSH[code]
        mesh.order = max(mesh.order, 1 + (nodes > corners))
        for row in rows[k + 1:k + 1 + n]:
            mesh.add(d, row[1:1 + corners], groups.get((d, entity), ()))
        k += 1 + n
    return mesh


def gmsh1(data):
    mesh = Mesh("MSH 1")
    lines = [line.split() for line in data.decode("latin-1").splitlines()]
    where = {line[0]: k for k, line in enumerate(lines) if line and line[0].startswith("$")}
    for f in lines[where["$NOD"] + 2:where["$ENDNOD"]]:
        mesh.nodes[int(f[0])] = tuple(map(float, f[1:4]))
    for f in lines[where["$ELM"] + 2:where["$ENDELM"]]:
        if f:
            d, corners, nodes = GMSH[int(f[1])]
            mesh.order = max(mesh.order, 1 + (nodes > corners))
            mesh.add(d, map(int, f[5:5 + corners]), [f[2]] if f[2] != "0" else [])
    return mesh


def gmsh_binary(data, version, mesh):
    mark = re.search(rb"\$MeshFormat\s+\S+\s+1\s+\d+[^\n]*\n(....)", data, re.S)
    order = "<" if mark[1] == b"\1\0\0\0" else ">"
    names = {}
    found = re.search(rb"\$PhysicalNames\s(.*?)\$EndPhysicalNames", data, re.S)
    for line in found[1].decode("latin-1").splitlines() if found else []:
        row = re.match(r'\s*(\d+)\s+(-?\d+)\s+"(.*)"', line)
        if row:
            names[int(row[1]), abs(int(row[2]))] = row[3].strip()
    call = lambda d, tag: names.get((d, abs(tag)), str(abs(tag)))
    at = 0

    def take(form):
        nonlocal at
        values = struct.unpack_from(order + form, data, at)
        at += struct.calcsize(order + form)
        return values

    def enter(name):
        nonlocal at
        place = data.find(b"\n$" + name + b"\n")
        if place < 0:
            return False
        at = place + len(name) + 3
        return True

    if version < 4:
        enter(b"Nodes")
        end = data.index(b"\n", at)
        count, at = int(data[at:end]), end + 1
        for _ in range(count):
            n, x, y, z = take("iddd")
            mesh.nodes[n] = (x, y, z)
        enter(b"Elements")
        end = data.index(b"\n", at)
        count, at = int(data[at:end]), end + 1
        while count > 0:
            code, follow, tags = take("iii")
            d, corners, nodes = GMSH[code]
            mesh.order = max(mesh.order, 1 + (nodes > corners))
            for _ in range(follow):
                row = take(f"{1 + tags + nodes}i")
                tag = row[1] if tags else 0
                mesh.add(d, row[1 + tags:1 + tags + corners], [call(d, tag)] if tag else [])
            count -= follow
        return mesh
    if version < 4.05:
        raise ValueError("binary MSH 4.0 is not read here")
    groups = {}
    if enter(b"Entities"):
        for d, count in enumerate(take("4Q")):
            for _ in range(count):
                tag = take("i")[0]
                take("3d" if d == 0 else "6d")
                groups[d, tag] = [call(d, t) for t in take(f"{take('Q')[0]}i")]
                if d:
                    take(f"{take('Q')[0]}i")
    enter(b"Nodes")
    blocks = take("4Q")[0]
    for _ in range(blocks):
        d, _, parametric = take("3i")
        n = take("Q")[0]
        numbers = take(f"{n}Q")
        for number in numbers:
            mesh.nodes[number] = take("3d")
            take(f"{d * parametric}d")
    enter(b"Elements")
    blocks = take("4Q")[0]
    for _ in range(blocks):
        _, entity, code = take("3i")
        d, corners, nodes = GMSH[code]
        mesh.order = max(mesh.order, 1 + (nodes > corners))
        for _ in range(take("Q")[0]):
            row = take(f"{1 + nodes}Q")
            mesh.add(d, row[1:1 + corners], groups.get((d, entity), ()))
    return mesh


def deck_type(name):
    """Dimension and nodes of an Abaqus element type."""
    name = name.upper()
    if re.match(r"(C3D|AC3D|DC3D|COH3D|F3D|SC\d|CIN3D|CSS\d)", name):
        return 3, 0
    if name.startswith("STRI"):
        return 2, {"STRI3": 3}.get(name, 6)
    found = re.match(r"(?:CPS|CPEG|CPE|CAX|CGAX|AC2D|ACAX|DC2D|DCAX|COH2D|COHAX|M3D|SFM3D|R3D|DS|US|S)(\d+)", name)
    if found and found[1] in "34689":
        return 2, int(found[1])
    return 1, 0


def deck(path, data):
    mesh = Mesh("Abaqus deck")
    state = {"scope": "", "block": None, "row": []}
    types, faces = Counter(), set()

    def read(data, folder, depth):
        lines = data.decode("latin-1").splitlines()
        k = 0
        while k < len(lines):
            line = lines[k].strip()
            k += 1
            if not line or line.startswith("**"):
                continue
            if line.startswith("*"):
                while line.endswith(",") and k < len(lines) and re.match(r"\s*[A-Za-z]", lines[k]):
                    line += lines[k].strip()
                    k += 1
                parts = [p.strip() for p in line[1:].split(",")]
                word = " ".join(parts[0].upper().split())
                options = {}
                for part in parts[1:]:
                    key, _, value = part.partition("=")
                    options[key.strip().upper()] = value.strip().strip('"')
                state["block"], state["row"] = None, []
                if word in ("PART", "INSTANCE"):
                    state["scope"] = word + options.get("NAME", "").upper()
                elif word in ("END PART", "END INSTANCE"):
                    state["scope"] = ""
                elif word == "NODE" and ("INPUT" not in options):
                    state["block"] = ("node",)
                elif word == "ELEMENT" and ("INPUT" not in options):
                    kind = options.get("TYPE", "").upper()
                    state["block"] = ("element", kind, deck_type(kind))
                elif word == "SURFACE" and options.get("TYPE", "ELEMENT").upper() == "ELEMENT":
                    state["block"] = ("surface",)
                elif word in ("NGEN", "NFILL", "NCOPY", "ELGEN", "ELCOPY", "NMAP", "SYSTEM"):
                    mesh.odd = f"nodes or elements made by *{word}"
                elif (word == "INCLUDE" or word in ("NODE", "ELEMENT")) and options.get("INPUT"):
                    file = folder / options["INPUT"]
                    if not file.is_file():
                        mesh.odd = f"included file {options['INPUT']} is not there"
                    elif depth < 8:
                        read(file.read_bytes(), file.parent, depth + 1)
                continue
            if state["block"] is None:
                continue
            fields = [f.strip() for f in line.split(",")]
            if state["block"][0] == "surface":
                faces.add(fields[1].upper() if len(fields) > 1 else "")
                continue
            if state["block"][0] == "node":
                xyz = [float(re.sub("[dD]", "e", f)) if f else 0.0 for f in fields[1:4]]
                mesh.nodes[state["scope"], int(fields[0])] = tuple((xyz + [0.0] * 3)[:3])
                continue
            _, kind, (dimension, nodes) = state["block"]
            if dimension != 2:
                if not state["row"]:
                    types[kind] += 1
                    mesh.add(dimension, ())
                state["row"] = [1] if line.endswith(",") else []
                continue
            state["row"] += [int(f) for f in fields if f]
            if len(state["row"]) > nodes:
                types[kind] += 1
                corners = 3 if nodes in (3, 6) else 4
                mesh.order = max(mesh.order, 1 + (nodes > corners))
                mesh.add(2, [(state["scope"], n) for n in state["row"][1:1 + corners]])
                state["row"] = []

    read(data, path.parent, 0)
    # Of a shell S1 and S2 are the two faces, S3 is the first edge (CalculiX); of a plane element S1 is the first edge.
    mesh.form += " (" + ", ".join(sorted(types)[:4]) + ")" if types else ""
    return mesh


def ucd(data):
    mesh = Mesh("AVS UCD")
    rows = [line.split("#")[0].split() for line in data.decode("latin-1").splitlines()]
    rows = [row for row in rows if row]
    nodes, cells = int(rows[0][0]), int(rows[0][1])
    for row in rows[1:1 + nodes]:
        mesh.nodes[int(row[0])] = tuple(map(float, row[1:4]))
    shapes = {"pt": 0, "line": 1, "tri": 2, "quad": 2, "tet": 3, "pyr": 3, "prism": 3, "hex": 3}
    for row in rows[1 + nodes:1 + nodes + cells]:
        mesh.add(shapes[row[2]], map(int, row[3:]))
    return mesh


def gid(data):
    mesh = Mesh("GiD")
    block, dimension, corners = None, 0, 0
    for line in data.decode("latin-1").splitlines():
        word = line.strip().lower()
        if word.startswith("mesh"):
            f = word.split()
            shape = f[f.index("elemtype") + 1]
            dimension, corners = {"triangle": (2, 3), "quadrilateral": (2, 4), "linear": (1, 2)}.get(shape, (3, 4))
            mesh.order = max(mesh.order, 1 + (int(f[f.index("nnode") + 1]) > corners))
        elif word in ("coordinates", "elements"):
            block = word
        elif word.startswith("end"):
            block = None
        elif word and block == "coordinates":
            f = word.split()
            mesh.nodes[int(f[0])] = tuple((list(map(float, f[1:4])) + [0.0])[:3])
        elif word and block == "elements":
            mesh.add(dimension, map(int, word.split()[1:1 + corners]))
    return mesh


def freefem(data):
    mesh = Mesh("FreeFem")
    rows = [row for row in (line.split() for line in data.decode("latin-1").splitlines()) if row]
    nodes, cells, edges = map(int, rows[0])
    body = rows[1:1 + nodes + cells + edges]
    if len(body) != nodes + cells + edges:
        raise ValueError("not FreeFem's")
    if {len(row) for row in body[:nodes]} != {3}:
        raise ValueError("not FreeFem's plane mesh")
    for k, row in enumerate(body[:nodes], 1):
        mesh.nodes[k] = (float(row[0]), float(row[1]), 0.0)
    for row in body[nodes:nodes + cells]:
        mesh.add(2, map(int, row[:3]))
    for row in body[nodes + cells:]:
        mesh.add(1, map(int, row[:2]), [row[2]])
    return mesh


def independent(path, data):
    """The mesh, or a word for what it is instead."""
    text = data.removeprefix(b"\xef\xbb\xbf").lstrip()
    if text.startswith(b"version https://git-lfs"):
        return "pointer to a file that is not stored (LFS)"
    if re.match(rb"\$(MeshFormat|NOD|Comments)", text):
        if b"$Elements" not in data and b"$ELM" not in data:
            return "no mesh"
        return gmsh(data)
    if text[:1] == b"*" or re.match(rb">\*\*", text):
        mesh = deck(path, data)
        if not mesh.elements:
            return "no mesh" if not mesh.odd else mesh.odd.replace(" is not there", "") and "mesh in a file that is not stored"
        return mesh
    if re.match(rb"mesh\s+dimension", text, re.I):
        return gid(data)
    plain = b"\n".join(line for line in text.splitlines() if not line.lstrip().startswith(b"#")).split(b"\n")
    plain = [line.split() for line in plain if line.strip()]
    whole = lambda row, n: len(row) == n and all(re.fullmatch(rb"\d+", f) for f in row)
    if plain and whole(plain[0], 5):
        return ucd(data)
    if plain and whole(plain[0], 3):
        return freefem(data)
    return "no mesh"


def plane(mesh):
    """Says what a mesh is, with its number of cells and area."""
    top = max((d for d, *_ in mesh.elements), default=0)
    if top == 3:
        return "volume"
    if top < 2:
        return "lines or points only"
    cells = [c for d, c, _ in mesh.elements if d == 2]
    missing = [n for c in cells for n in c if n not in mesh.nodes]
    if missing:
        return "plane" if mesh.form.startswith("Abaqus") and re.search(r"\((CPS|CPE|CAX)", mesh.form) else "surface, nodes missing"
    points = [mesh.nodes[n] for c in cells for n in c]
    spread = [max(p[k] for p in points) - min(p[k] for p in points) for k in range(3)]
    size = max(spread)
    if spread[2] <= 1e-9 * size:
        return "plane"
    if min(spread[:2]) <= 1e-9 * size:
        return "flat, but in the plane x-z or y-z"
    return "surface in space"


def area(mesh):
    total, seen = 0.0, set()
    for d, c, _ in mesh.elements:
        if d != 2 or frozenset(c) in seen:
            continue
        seen.add(frozenset(c))
        # Far from the origin the products would lose digits.
        p = [[x - y for x, y in zip(mesh.nodes[n], mesh.nodes[c[0]])] for n in c]
        total += abs(sum(p[k - 1][0] * p[k][1] - p[k][0] * p[k - 1][1] for k in range(len(p)))) / 2
    return total, len(seen)


def sides(mesh):
    """Groups of edges: how many different edges of cells each has."""
    of_cells = {frozenset((c[k - 1], c[k])) for d, c, _ in mesh.elements if d == 2 for k in range(len(c))}
    found = defaultdict(set)
    for d, c, groups in mesh.elements:
        if d == 1 and len(c) == 2 and frozenset(c) in of_cells:
            for group in groups:
                found[group].add(frozenset(c))
    return {name: len(edges) for name, edges in found.items()}


def run(nndd, *words, seconds=60):
    try:
        done = subprocess.run([nndd, *map(str, words)], capture_output=True, timeout=seconds, text=True, errors="replace")
    except subprocess.TimeoutExpired:
        return -99, "", "time-out"
    return done.returncode, done.stdout, done.stderr


def toml(text):
    return json.dumps(text, ensure_ascii=False)


def case(folder, file, regions, support, box):
    """Writes a case of one body; `support` is a side, or None for all edges in the box."""
    side = ""
    if support is None:
        (x, y) = [(a - 0.01 * (b - a) - 1e-9, b + 0.01 * (b - a) + 1e-9) for a, b in box]
        side = f'[[body.side]]\nname = "held"\nbox = {{ x = [{x[0]!r}, {x[1]!r}], y = [{y[0]!r}, {y[1]!r}] }}\n'
    region = f", region = [{', '.join(map(toml, regions))}]" if regions else ""
    path = folder / "case.toml"
    path.write_text(f"""schema = 1
contact = []
[materials.m]
young = 1.0
poisson = 0.3
[[body]]
name = "body"
material = "m"
mesh = {{ file = {toml(file)}{region} }}
{side}[[body.displacement]]
on = {toml(support if support is not None else "held")}
fixed = true
[output]
directory = {toml(str(folder / "out"))}
""")
    return path


def vtu_area(path):
    """Area and number of triangles of an nndd answer, from its .vtu file."""
    import meshio
    mesh = meshio.read(path)
    tri = mesh.cells_dict["triangle"]
    p = mesh.points[tri][:, :, :2]
    a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    return float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2), len(tri)


def try_file(nndd, folder, path, mesh, verify):
    """Runs the check; returns outcome, message, remarks."""
    remarks = []
    name = path.name
    code, out, err = run(nndd, "mesh", "--format", "json", path)
    listing = json.loads(out.splitlines()[-1]) if code == 0 and out.strip() else None
    if code not in (0, 3, 7):
        return "defect", f"nndd mesh ends with {code}", err.strip(), remarks
    regions, edges, box = [], [], [(-1e30, 1e30)] * 2
    if listing:
        groups = listing["groups"]
        regions = [g["name"] for g in groups if g["dimension"] == 2 and g["cells"]]
        regions = regions if len([g for g in groups if g["dimension"] == 2]) > 1 else []
        edges = [g["name"] for g in groups if g["dimension"] == 1 and g["edges"]] + [g["name"] for g in groups if g["dimension"] == 0]
        low, high = listing["bounding_box"]
        box = list(zip(low, high))[:2]
    tries = [(edges[0] if edges else None, regions)] + ([(None, regions)] if edges else [])
    # Parts that overlap are bodies of their own.
    tries += [(None, [region]) for region in regions] if len(regions) > 1 else []
    alone, first = [], None
    for support, taken in tries:
        file = case(folder, str(path), taken, support, box)
        code, out, err = run(nndd, "check", "--format", "json", file)
        events = [json.loads(line) for line in out.splitlines() if line.startswith("{")]
        if code not in (0, 3, 4, 7):
            return "defect", f"nndd check ends with {code}", err.strip(), remarks
        if len(regions) > 1 and len(taken) == 1:
            alone.append(code)
            continue
        if code == 0:
            break
        first = first or (code, events, err)
        if support is not None:
            remarks.append("the first edge group is no support alone")
        elif not any("overlap" in e.get("message", "") for e in events):
            break
    if alone and not any(alone):
        remarks.append("regions overlap; each loads as a body of its own")
        return "loads", "", "", remarks
    if alone:
        code, events, err = first
    if "panicked" in err or "RUST_BACKTRACE" in err:
        return "defect", "panic", err.strip(), remarks
    if code != 0:
        return "refused", next((e["message"] for e in events if e["event"] == "failed"), ""), err.strip(), remarks
    event = events[-1]
    body = event["bodies"][0]
    remarks += event.get("warnings", [])
    if isinstance(mesh, Mesh) and verify:
        own, count = area(mesh)
        listed = {k: v for k, v in body["sides"].items() if k != "held"}
        expected = sides(mesh)
        if mesh.form.startswith("MSH") and listed != expected:
            remarks.append(f"SIDES {listed} instead of {expected}")
        if body["triangles"] <= verify:
            case(folder, str(path), regions, None, box)
            code, out, err = run(nndd, "solve", "--force", folder / "case.toml", seconds=120)
            if "there are no unknowns" in err:
                (x, y) = box
                case(folder, str(path), regions, None, [x, (y[0], (y[0] + y[1]) / 2)])
                code, out, err = run(nndd, "solve", "--force", folder / "case.toml", seconds=120)
            file = folder / "out" / "body.vtu"
            if code in (0, 5, 6) and file.is_file():
                got, triangles = vtu_area(file)
                if abs(got - own) > 1e-9 * abs(own):
                    remarks.append(f"AREA {got} instead of {own}, {triangles} triangles, {count} cells")
                else:
                    remarks.append("area agrees")
                file.unlink()
            else:
                remarks.append(f"not solved: {code} {err.strip()[:300]}")
    return "loads", "", "", remarks


def table(rows):
    """Prints the two tables of README.md."""
    kinds = ["loads", "refused, clear", "refused, poor", "defect"]
    print("| repository | files | the same twice | plane | " + " | ".join(kinds) + " | volume | surface or turned plane | lines, points | no mesh, or not stored |")
    print("|---|" + "---|" * (len(kinds) + 7))
    total = Counter()
    names = list(dict.fromkeys(row[0] for row in rows))
    for name in names + ["all"]:
        of = [row for row in rows if name in (row[0], "all")]
        plain = [row for row in of if row[5] == "plane"]
        count = Counter(row[6] for row in plain)
        kind = Counter(row[5] for row in of)
        space = sum(n for key, n in kind.items() if key.startswith(("surface", "flat")))
        rest = len(of) - len(plain) - space - kind["volume"] - kind["lines or points only"] - kind["same as another"]
        print("|", " | ".join(map(str, [name, len(of), kind["same as another"], len(plain)] + [count[k] for k in kinds]
                                  + [kind["volume"], space, kind["lines or points only"], rest])), "|")
    print()
    found = Counter((reason(row[7])[0], row[6]) for row in rows if row[5] == "plane" and row[6].startswith("refused"))
    for (label, outcome), count in found.most_common():
        print("|", label, "|", outcome, "|", count, "|")
    print()
    for form, count in Counter((re.sub(r" \(.*", "", r[2]), r[6]) for r in rows if r[5] == "plane").most_common():
        print(form, count)


def main():
    p = argparse.ArgumentParser()
    p.add_argument("--nndd", required=True)
    p.add_argument("--work", type=Path, required=True)
    p.add_argument("--out", type=Path, required=True)
    p.add_argument("--verify", type=int, default=0, help="solve meshes of at most so many triangles, compare areas (needs meshio)")
    p.add_argument("repositories", nargs="+")
    a = p.parse_args()
    nndd = str(Path(a.nndd).resolve())
    folder = a.work.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    a.out.mkdir(parents=True, exist_ok=True)
    seen, rows, totals = {}, [], Counter()
    for entry in a.repositories:
        repository, root = entry.split("=", 1)
        root = Path(root).resolve()
        files = sorted(f for f in root.rglob("*") if f.suffix.lower() in (".msh", ".inp") and f.is_file() and not f.is_symlink())
        for path in files:
            totals[repository] += 1
            data = path.read_bytes()
            key = hashlib.sha256(data).digest()
            if key in seen:
                rows.append([repository, str(path.relative_to(root)), "", "", "", "same as another", "", "", seen[key], ""])
                continue
            seen[key] = f"{repository}/{path.relative_to(root)}"
            try:
                mesh = independent(path, data)
                kind = plane(mesh) if isinstance(mesh, Mesh) else mesh
            except Exception as error:
                mesh, kind = None, f"not understood: {type(error).__name__}: {error}"
            outcome, message, err, remarks = try_file(nndd, folder, path, mesh, a.verify if kind == "plane" else 0)
            if outcome == "refused" and kind == "plane":
                outcome = "refused, clear" if reason(message)[1] else "refused, poor"
            message = message.replace(str(path), path.name).replace(str(path.parent) + "/", "")
            form = mesh.form if isinstance(mesh, Mesh) else ""
            nodes = len(mesh.nodes) if isinstance(mesh, Mesh) else ""
            cells = sum(d == 2 for d, *_ in mesh.elements) if isinstance(mesh, Mesh) else ""
            rows.append([repository, str(path.relative_to(root)), form, nodes, cells, kind, outcome, message, "; ".join(map(str, remarks)), err])
            print(repository, path.relative_to(root), kind, outcome, message[:150], file=sys.stderr)
    with open(folder / "all.json", "w") as file:
        json.dump(rows, file, indent=0)
    with open(a.out / "meshes.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["repository", "path", "format", "nodes", "cells", "outcome", "reason"])
        for row in rows:
            if row[5] == "plane":
                # The place in the case file is of no interest.
                out.writerow(row[:5] + [row[6], re.sub(r"^\S*case\.toml:\d+:\d+: ", "", row[7])])
    table(rows)


if __name__ == "__main__":
    main()
