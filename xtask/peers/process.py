"""What a process knows of itself: its memory, and the BLAS it has loaded."""

import os


def resident():
    """Resident memory in bytes; None where the system does not say."""
    try:
        with open("/proc/self/statm") as stat:
            return int(stat.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return None


def peak():
    """Largest resident memory so far in bytes; None where the system does not say."""
    try:
        with open("/proc/self/status") as status:
            line = next(line for line in status if line.startswith("VmHWM:"))
            return int(line.split()[1]) * 1024
    except (OSError, StopIteration):
        return None


def blas():
    """The file names of the BLAS libraries in memory, numpy's own left out: what a compiled extension calls."""
    try:
        with open("/proc/self/maps") as maps:
            paths = {line.split()[-1] for line in maps if ".so" in line}
    except OSError:
        return None
    names = {os.path.basename(path) for path in paths if "numpy" not in path and "scipy" not in path}
    wanted = sorted(name for name in names if "blas" in name or name.startswith("libmkl_rt"))
    return ", ".join(wanted) or None
