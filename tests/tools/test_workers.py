"""Independent work over processes and over a Dask cluster: order, losses, nothing left behind."""

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pieces_of_work
import psutil
import pytest
from terminal_session import PATIENCE

from mukca import MukcaError
from mukca.tools.parallel import Workers

pytestmark = pytest.mark.slow

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
"""In which a program finds the work."""


def until(condition, seconds=PATIENCE):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_one_worker_is_this_process():
    assert Workers(1).map(lambda x: 2 * x, [3, 1]) == [6, 2]


def test_a_lost_process_costs_nothing_but_time(tmp_path):
    done = []
    work = partial(pieces_of_work.square_after_one_death, tmp_path / "died")
    assert Workers(2).map(work, range(8), done.append) == [n * n for n in range(8)]
    assert sorted(done) == list(range(8)) and (tmp_path / "died").exists()
    assert multiprocessing.active_children() == []


def test_an_interruption_is_for_the_parent_alone():
    """Also before a process has run any code of ours, as while it loads Python."""
    masks = Workers(2).map(pieces_of_work.blocked_signals, [0, 1])
    assert all(signal.SIGINT in mask for mask in masks)
    assert signal.SIGINT not in pieces_of_work.blocked_signals(0)


def test_work_that_ends_every_process_ends_itself():
    with pytest.raises(MukcaError, match="2 of 2 left to do"):
        Workers(2).map(pieces_of_work.die, range(2))


def test_what_a_piece_raises_is_raised_and_nothing_is_left():
    with pytest.raises(ValueError, match="no "):
        Workers(2).map(pieces_of_work.refuse, range(4))
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_nothing_outlives_the_one_who_asked(how, tmp_path):
    code = (
        "import sys, pieces_of_work; from functools import partial; from pathlib import Path\n"
        "from mukca.tools.parallel import Workers\n"
        "if __name__ == '__main__':\n"
        "    work = partial(pieces_of_work.say_who_and_sleep, Path(sys.argv[1]))\n"
        "    Workers(2).map(work, range(4))\n"
    )
    (tmp_path / "ask.py").write_text(code)
    asking = subprocess.Popen(
        [sys.executable, str(tmp_path / "ask.py"), str(tmp_path)],
        env=ENVIRONMENT,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    until(lambda: len(list(tmp_path.glob("*.pid"))) == 2)
    workers = [psutil.Process(int(file.stem)) for file in tmp_path.glob("*.pid")]
    if how == signal.SIGINT:  # a terminal's Ctrl-C goes to all of them
        os.killpg(asking.pid, how)
    else:
        asking.kill()
    _, err = asking.communicate(timeout=PATIENCE)
    until(lambda: not any(worker.is_running() for worker in workers))
    assert err.count(b"Traceback") <= 1  # the one who asked; no worker has anything to say


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """A scheduler's address, and its two workers."""
    pytest.importorskip("distributed")
    folder = tmp_path_factory.mktemp("dask")
    environment = ENVIRONMENT | {"DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "300s"}
    started = []

    def start(*words):
        command = [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]]
        quiet = dict.fromkeys(("stdout", "stderr"), subprocess.DEVNULL)
        process = subprocess.Popen(command, env=environment, cwd=folder, **quiet)
        started.append(process)
        return process

    file = folder / "scheduler.json"
    start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
          "--scheduler-file", str(file))  # fmt: skip
    until(lambda: file.exists() and file.read_text().endswith("}"))  # it is there before its text
    address = json.loads(file.read_text())["address"]
    words = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", "600s")
    workers = [start("dask_worker", address, *words) for _ in range(2)]
    yield address, workers
    for process in started:
        process.kill()  # a worker that is asked to end waits for its scheduler first
    for process in started:
        process.wait()


def ran(*words):
    """Run Python with words; Dask stays out of this process, where every warning is an error."""
    command = [sys.executable, *map(str, words)]
    environment = ENVIRONMENT | {"OPENBLAS_NUM_THREADS": "1"}
    return subprocess.run(command, env=environment, capture_output=True, text=True)


def test_a_lost_worker_of_a_cluster_costs_nothing_but_time(cluster, tmp_path):
    address, workers = cluster
    code = (
        "import sys, pieces_of_work; from functools import partial; from pathlib import Path\n"
        "from mukca.tools.parallel import Workers\n"
        "work = partial(pieces_of_work.square_after_one_death, Path(sys.argv[1]))\n"
        "workers = Workers(cluster=sys.argv[2])\n"
        "print(workers.map(work, range(8)))\n"
        "done, many = [], range(200)\n"
        "print(workers.map(work, many, done.append) == [n * n for n in many])\n"
        "print(sorted(done) == [*many], workers.map(work, []))\n"
    )
    result = ran("-c", code, tmp_path / "died", address)
    told = [str([n * n for n in range(8)]), "True", "True []"]
    assert result.stdout.splitlines() == told, result.stderr
    assert (tmp_path / "died").exists()
    until(lambda: sum(worker.poll() is not None for worker in workers) == 1)


def test_a_cluster_that_is_not_there_is_told():
    pytest.importorskip("distributed")
    code = (
        "from mukca.tools.parallel import Workers, processes as cluster\n"
        "cluster.ANSWER_SECONDS = 0.3\n"
        "try: Workers(cluster='tcp://127.0.0.1:9').map(abs, [1, 2])\n"
        "except cluster.UsageError as error: print(error)\n"
    )
    assert "no Dask scheduler answers there" in ran("-c", code).stdout


def test_without_dask_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MukcaError, match=r"pip install 'mukca\[cluster\]'"):
        Workers(cluster="tcp://127.0.0.1:9").map(abs, [1, 2])


def test_the_first_process_of_all_is_out_of_reach_of_ctrl_c():
    """Python's own helper, which is started with the first process, unblocks the signal."""
    code = """
import signal
from multiprocessing import resource_tracker
from mukca.tools.parallel import started_apart
with started_apart():
    resource_tracker.ensure_running()
    print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "True\n"
