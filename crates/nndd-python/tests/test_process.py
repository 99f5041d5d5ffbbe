"""The process around a run: callbacks, signals, threads, forks, memory of exceptions."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import nndd
import pytest
from conftest import CASES, blocks, same


def long(cells: int = 160) -> nndd.Problem:
    """A problem that takes some seconds."""
    return blocks((cells, cells // 2))


def test_events_come_in_their_order_on_the_thread_that_called() -> None:
    events: list[dict[str, Any]] = []
    threads = set()

    def tell(event: dict[str, Any]) -> None:
        events.append(event)
        threads.add(threading.get_ident())

    solution = nndd.solve(CASES / "adaptive.toml", on_iteration=tell)
    meshes = [event for event in events if event["event"] == "mesh"]
    assert [mesh["step"] for mesh in meshes] == solution.adaptive["step"].tolist()
    assert [mesh["relative"] for mesh in meshes] == solution.adaptive["relative"].tolist()
    assert [event["event"] for event in events[:2]] == ["iteration", "iteration"]
    assert threads == {threading.get_ident()}
    steps: list[dict[str, Any]] = []
    nndd.solve(CASES / "shear.toml", on_iteration=lambda event: steps.append(event))
    found = [event["step"] for event in steps if event["event"] == "load_step"]
    assert found == list(range(1, steps[-1]["of"] + 1))


def test_what_a_callback_raises_ends_the_run() -> None:
    calls = []

    def stop(event: dict[str, Any]) -> None:
        calls.append(event)
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        nndd.solve(CASES / "adaptive.toml", adapt__target_relative_error=0.005, on_iteration=stop)
    assert len(calls) == 1


def test_other_threads_run_while_it_computes() -> None:
    ticks: list[float] = []
    done = threading.Event()

    def tick() -> None:
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    started = time.perf_counter()
    long().solve(threads=1)
    ended = time.perf_counter()
    done.set()
    thread.join()
    within = [t for t in ticks if started < t < ended]
    # With the lock held there would be one or two.
    assert len(within) > 10


def test_two_threads_at_once() -> None:
    problems: list[Callable[[], nndd.Solution]] = [
        lambda: blocks((24, 12)).solve(0.03),
        lambda: nndd.solve(CASES / "adaptive.toml"),
        lambda: nndd.solve(CASES / "coulomb.toml"),
        lambda: blocks((12, 6), gap=lambda x, y: 1e-4 * x).solve(),
    ]
    alone = [problem() for problem in problems]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda problem: problem(), problems * 2))
    for k, solution in enumerate(together):
        assert same(solution, alone[k % 4])


def _in_child(queue: Any) -> None:
    solution = blocks((12, 6)).solve(threads=2)
    queue.put((str(solution.status), solution.relative))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_fork_after_a_solve(tmp_path: Path) -> None:
    adaptive = blocks((12, 6)).solve(0.1, threads=2)
    before = blocks((12, 6)).solve(threads=2)
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=_in_child, args=(queue,))
    child.start()
    assert queue.get(timeout=60) == ("converged", before.relative)
    child.join(60)
    assert child.exitcode == 0
    # A child that ends does not take the files of its parent's runs with it.
    pid = os.fork()
    if pid == 0:
        status = 1
        try:
            del adaptive
            status = 0
        finally:
            os._exit(status)
    assert os.waitpid(pid, 0)[1] == 0
    files = adaptive.save(tmp_path)
    steps = [name for name in files if name.startswith("fields/")]
    assert len(steps) == 3 * len(adaptive.adaptive)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_fork_during_a_solve() -> None:
    """Another thread computes; the child computes on threads of its own."""
    with ThreadPoolExecutor(1) as pool:
        running = pool.submit(lambda: long().solve())
        time.sleep(0.2)
        pid = os.fork()
        if pid == 0:
            status = 1
            try:
                status = 0 if blocks((12, 6)).solve().valid else 2
            finally:
                os._exit(status)
        assert os.waitpid(pid, 0)[1] == 0
        assert running.result().valid


INTERRUPTED = """
    import os, signal, sys, threading, time
    import nndd
    sys.path.insert(0, {tests!r})
    from conftest import blocks

    started = []

    def press(event):
        # The first mesh has a result.
        if event["event"] == "mesh" and not started:
            started.append(time.perf_counter())
            threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()

    solution = blocks((16, 8)).solve(0.0008, on_iteration=press, threads=2)
    seconds = time.perf_counter() - started[0]
    print(solution.status, solution.status.code, solution.valid, len(solution.adaptive) >= 1, seconds)
    # The next run is not interrupted.
    print(blocks().solve().status)
"""


def run_script(text: str, timeout: float = 300.0) -> subprocess.CompletedProcess[str]:
    script = textwrap.dedent(text.replace("{tests!r}", repr(str(Path(__file__).parent))))
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=timeout, check=False)


def test_ctrl_c_returns_what_there_is() -> None:
    done = run_script(INTERRUPTED)
    assert done.returncode == 0, done.stderr
    first, second = done.stdout.splitlines()
    word, code, valid, has_meshes, seconds = first.split()
    assert (word, code, valid, has_meshes, second) == ("interrupted", "130", "True", "True", "converged")
    # A second after the signal, which comes after 0.2, or the longest step; other work may slow the machine.
    assert float(seconds) < 20.0


def test_ctrl_c_before_a_result_is_an_exception() -> None:
    done = run_script("""
        import os, signal, sys, threading
        import nndd
        sys.path.insert(0, {tests!r})
        from conftest import blocks

        def gap(x, y):
            os.kill(os.getpid(), signal.SIGINT)
            return 0.0 * x

        try:
            blocks((200, 100), gap=gap).solve()
        except KeyboardInterrupt:
            print("interrupted")
        print(blocks().solve().status)
    """)
    assert (done.returncode, done.stdout.split()) == (0, ["interrupted", "converged"]), done.stderr


def test_a_second_ctrl_c_does_not_wait() -> None:
    done = run_script("""
        import os, signal, sys, threading, time
        import nndd
        sys.path.insert(0, {tests!r})
        from conftest import blocks

        def press():
            for _ in range(2):
                os.kill(os.getpid(), signal.SIGINT)
                time.sleep(0.15)

        # Large: a fast machine must not end between the two signals.
        problem = blocks((800, 400))
        threading.Timer(0.5, press).start()
        started = time.perf_counter()
        try:
            problem.solve(0.001)
            print("a result")
        except KeyboardInterrupt:
            print("left alone", flush=True)
        os._exit(0)
    """)
    assert (done.returncode, done.stdout.strip()) == (0, "left alone"), done.stderr


def test_another_handler_of_a_signal_may_raise() -> None:
    done = run_script("""
        import signal, sys
        sys.path.insert(0, {tests!r})
        from conftest import blocks

        class Late(Exception):
            pass

        def handler(number, frame):
            raise Late

        problem = blocks((160, 80))
        signal.signal(signal.SIGALRM, handler)
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        try:
            problem.solve(0.001)
        except Late:
            print("late")
    """)
    assert (done.returncode, done.stdout.strip()) == (0, "late"), done.stderr


def test_signals_are_the_interpreters_own() -> None:
    handler = signal.getsignal(signal.SIGINT)
    blocks().solve()
    assert signal.getsignal(signal.SIGINT) is handler
