"""Measures 820,000 unknowns from Python beside the command: the way in and out, and the peak of the memory.

Usage: python tests/large.py NNDD, with the program nndd. It needs about 3 GiB and is no test: times depend on the machine.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

CASE = """
schema = 1
[materials.m]
young = 1000.0
poisson = 0.3
[[body]]
name = "upper"
material = "m"
generator = {{ kind = "block", origin = [0.0, 1.0], size = [2.0, 1.0], cells = [{0}, {1}] }}
[[body.displacement]]
on = "top"
ux = 0.0
uy = -0.01
[[body]]
name = "lower"
material = "m"
generator = {{ kind = "block", size = [2.0, 1.0], cells = [{0}, {1}] }}
[[body.displacement]]
on = "bottom"
fixed = true
[contact]
surfaces = ["bottom", "top"]
[output]
vtu = false
"""


def by_command(program: str, cells: tuple[int, int]) -> tuple[float, float, float]:
    """Seconds of the run without writing, of them for the meshes, and peak of the memory, MiB, of the command."""
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder) / "large.toml"
        case.write_text(CASE.format(*cells))
        subprocess.run([program, "solve", str(case), "--out", f"{folder}/out", "--quiet"], check=True)
        report = json.loads((Path(folder) / "out" / "report.json").read_text())
    timings = report["timings"]
    return timings["total"] - timings["write"], timings["mesh"], report["run"]["memory_peak"] / 2**20


def by_python(cells: tuple[int, int]) -> dict[str, float]:
    """The same from arrays of NumPy to arrays of NumPy, in this process."""
    import nndd

    blocks = [nndd.Mesh.block((0, y), (2, 1), cells) for y in (1, 0)]
    meshes = [nndd.Mesh(mesh.points, mesh.triangles, mesh.sides) for mesh in blocks]
    del blocks
    before = time.perf_counter()
    steel = nndd.Material(1000.0, 0.3)
    upper = nndd.Body(meshes[0], steel, "upper").displace("top", ux=0.0, uy=lambda x, y: -0.01 + 0 * x)
    lower = nndd.Body(meshes[1], steel, "lower").fix("bottom")
    problem = nndd.Problem([upper, lower], [nndd.Contact(upper, lower, ("bottom", "top"))])
    solution = problem.solve(output__vtu=False)
    solved = time.perf_counter()
    for body in solution.bodies:
        _ = (body.displacement, body.stress, body.von_mises, body.error_density, body.mesh)
    _ = [pair.pressure for pair in solution.contacts]
    done = time.perf_counter()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10
    timings = solution.report()["timings"]
    unknowns = sum(body["unknowns"] for body in solution.report()["bodies"])
    inside = timings["total"] - timings["mesh"]
    return {
        "unknowns": unknowns,
        "whole": done - before,
        "in": solved - before - inside,
        "solve": inside,
        "out": done - solved,
        "peak": peak,
    }


def main() -> None:
    """Print the figures of both."""
    cells = (640, 320)
    if sys.argv[1:] == ["--python"]:
        print(json.dumps(by_python(cells)))
        return
    seconds, meshes, peak = by_command(sys.argv[1], cells)
    # A process of its own, so that its memory is its own.
    said = subprocess.run([sys.executable, __file__, "--python"], check=True, capture_output=True, text=True).stdout
    found = json.loads(said)
    print(f"{found['unknowns']:.0f} unknowns")
    print(f"command  {seconds:6.2f} s, peak {peak:.0f} MiB")
    print(f"Python   {found['whole']:6.2f} s, peak {found['peak']:.0f} MiB ({found['peak'] / peak - 1:+.1%})")
    parts = ", ".join(f"{part} {found[part]:.2f} s" for part in ("in", "solve", "out"))
    # The command makes meshes too.
    overhead = (found["in"] - meshes + found["out"]) / (found["solve"] + meshes)
    print(f"{parts}; the command makes its meshes in {meshes:.2f} s, so in and out are {overhead:.1%} of the solve")


if __name__ == "__main__":
    main()
