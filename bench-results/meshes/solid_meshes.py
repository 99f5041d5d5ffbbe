#!/usr/bin/env python3
"""Tries `nndd check` on every volume mesh (.msh, .inp, .e, .exo, .g, .gen, .vtu) of some repositories.

    python3 solid_meshes.py --nndd target/release/nndd --work runs/meshes --out bench-results/meshes \
        mfem/mfem=CHECKOUT dealii/dealii=CHECKOUT ...

Each argument is a repository's name and a folder with its files. Files with the same contents count once. A file is a volume mesh if
`nndd mesh` finds volumes in it, or if it names types of volumes and nndd refuses it. Each gets a case of one body with all regions, clamped
on its whole boundary; if that is refused, one for each of the first regions. Needs Python 3 and nothing else. Writes solid_meshes.csv to --out.
"""

import argparse
import csv
import hashlib
import json
import re
import subprocess
from collections import Counter
from pathlib import Path

ENDINGS = (".msh", ".inp", ".e", ".exo", ".g", ".gen", ".vtu")
MOST_REGIONS = 10


def run(nndd, *words):
    try:
        done = subprocess.run([nndd, *map(str, words)], capture_output=True, timeout=120, text=True, errors="replace")
    except subprocess.TimeoutExpired:
        return -1, "", "time-out"
    return done.returncode, done.stdout, done.stderr.strip()


def names_volumes(data):
    """Tells if a file that is refused names types of volumes: in a deck, in an Exodus file, or by Gmsh's numbers in text."""
    if re.search(rb"(?im)^\s*\*ELEMENT\s*,[^\n]*TYPE\s*=\s*(C3D|DC3D|AC3D|F3D|SC|COH3D)", data):
        return True
    if data[:3] == b"CDF" or data[:4] == b"\x89HDF":
        return b"connect1" in data and re.search(rb"(?i)(HEX|TETRA|TET4|WEDGE|PYRAMID)", data) is not None
    elements = re.search(rb"\$Elements\s+(.*)", data, re.S)
    rows = [line.split() for line in elements[1].splitlines()] if elements else []
    volumes = {b"4", b"5", b"6", b"7", b"11", b"12", b"13", b"14", b"17", b"18", b"19", b"29", b"30", b"31", b"90", b"92", b"93"}
    return any(len(row) > 7 and row[1] in volumes for row in rows)


def case(folder, mesh, regions, box):
    region = f", region = {json.dumps(regions)}" if regions else ""
    limits = ", ".join(f"{axis} = [{low - 1e-2 * (high - low) - 1e-9!r}, {high + 1e-2 * (high - low) + 1e-9!r}]"
                       for axis, low, high in zip("xyz", *box))
    path = folder / "case.toml"
    path.write_text(f"""schema = 1
contact = []
[materials.m]
young = 1.0
poisson = 0.3
[[body]]
name = "body"
material = "m"
mesh = {{ file = {json.dumps(str(mesh))}{region} }}
[[body.side]]
name = "held by this case"
box = {{ {limits} }}
[[body.displacement]]
on = "held by this case"
fixed = true
""")
    return path


def try_file(nndd, folder, path):
    """Returns outcome, format, numbers of nodes and volumes, message."""
    code, out, err = run(nndd, "mesh", "--format", "json", path)
    if code in (3, 7):
        return ("refused by the reader" if names_volumes(path.read_bytes()) else None), "", "", "", err
    if code != 0:
        return "defect", "", "", "", err
    found = json.loads(out.splitlines()[-1])
    volumes = sum(n for kind, n in found["cells"].items() if re.search("tetra|hexa|prism|pyramid", kind))
    if volumes == 0:
        return None, "", "", "", ""
    regions = [group["name"] for group in found["groups"] if group["dimension"] == 3 and group["volumes"]]
    tries = [regions] + [[region] for region in regions[:MOST_REGIONS]] if len(regions) > 1 else [[]]
    messages = []
    for taken in tries:
        code, _, err = run(nndd, "check", case(folder, path, taken, found["bounding_box"]))
        if code == 0:
            outcome = "loads" if not messages else "a region loads"
            return outcome, found["format"], found["nodes"], volumes, "; ".join(messages[:1])
        if code not in (3, 4, 7):
            return "defect", found["format"], found["nodes"], volumes, err
        messages.append(err)
    return "refused by the case", found["format"], found["nodes"], volumes, messages[0]


def main():
    p = argparse.ArgumentParser()
    p.add_argument("--nndd", required=True)
    p.add_argument("--work", type=Path, required=True)
    p.add_argument("--out", type=Path, required=True)
    p.add_argument("repositories", nargs="+")
    a = p.parse_args()
    nndd, folder = str(Path(a.nndd).resolve()), a.work.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    seen, rows = set(), []
    for entry in a.repositories:
        repository, root = entry.split("=", 1)
        root = Path(root).resolve()
        for path in sorted(f for f in root.rglob("*") if f.suffix.lower() in ENDINGS and f.is_file()):
            data = path.read_bytes()
            key = hashlib.sha256(data).digest()
            if key in seen or not data or data.startswith(b"version https://git-lfs"):
                continue
            seen.add(key)
            outcome, form, nodes, volumes, message = try_file(nndd, folder, path)
            if outcome is not None:
                said = message.split("\n")[0].replace(str(path), path.name).replace(str(folder) + "/", "")
                rows.append([repository, str(path.relative_to(root)), form, nodes, volumes, outcome, said])
    with open(a.out / "solid_meshes.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["repository", "path", "format", "nodes", "volumes", "outcome", "reason"])
        out.writerows(rows)
    outcomes = ["loads", "a region loads", "refused by the case", "refused by the reader", "defect"]
    print("| repository | volume meshes | " + " | ".join(outcomes) + " |\n|---|" + "---:|" * (len(outcomes) + 1))
    for name in list(dict.fromkeys(row[0] for row in rows)) + ["all"]:
        count = Counter(row[5] for row in rows if name in (row[0], "all"))
        print("|", " | ".join(map(str, [name, sum(count.values())] + [count[outcome] for outcome in outcomes])), "|")
    print()
    for form, count in Counter((re.sub(",? (binary|text).*", "", row[2]), row[5]) for row in rows).most_common():
        print(form, count)


if __name__ == "__main__":
    main()
