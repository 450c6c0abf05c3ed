"""The coordinating process is interrupted or killed: nothing is lost, doubled or left running."""

import os
import random
import signal
import sqlite3
import time
from collections import Counter
from contextlib import closing
from pathlib import Path

import pytest
import study_deeds as deeds

PATIENCE = 60.0


def wait_until(condition):
    """Polls, and fails only after much longer than it should take on a busy machine."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it did not come to pass"
        time.sleep(0.02)


def finished(path):
    """Keys in the store, as soon as there is one."""
    if not path.exists():
        return []
    try:
        with closing(sqlite3.connect(path)) as connection:
            return [key for (key,) in connection.execute("SELECT key FROM results")]
    except sqlite3.OperationalError:  # there are no tables yet
        return []


def is_running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.fixture
def command(study, tmp_path):
    """The command line of a study with many tasks, and its store."""
    store = tmp_path / "s.db"
    path = study(seeds=range(15))
    return ("study", "run", path, "--store", store, "--workers", "2"), store


def test_killed_again_and_again(command, fake_mamo, did):
    arguments, store = command
    rng = random.Random(1)
    kept = set()
    for _ in range(3):
        process = fake_mamo(*arguments)
        target = len(kept) + rng.randint(1, 5)
        wait_until(lambda target=target: len(finished(store)) >= target)
        time.sleep(0.03 * rng.random())
        process.kill()
        process.communicate()
        assert kept <= set(finished(store))
        kept = set(finished(store))
    last = fake_mamo(*arguments, "--json")
    out, err = last.communicate(timeout=PATIENCE)
    assert last.returncode == 0, err
    assert '"total": 30,\n  "done": 30,' in out
    assert '"duplicates": 0' in out
    assert f"{len(kept)} of 30 tasks are done already" in err
    keys = finished(store)
    assert kept <= set(keys)
    assert len(keys) == len(set(keys)) == 30
    times = Counter(did("solve"))
    assert len(times) == 30
    # What was under way, or done and not yet written, is done again: at most both workers' task
    # and what they had sent.
    assert sum(times.values()) - 30 <= 3 * 4


def test_interrupted(command, fake_mamo):
    arguments, store = command
    process = fake_mamo(*arguments)
    wait_until(lambda: len(finished(store)) >= 3)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert out == ""
    assert err.endswith("interrupted\n")
    assert "Traceback" not in err
    again = fake_mamo(*arguments)
    assert again.wait(PATIENCE) == 0
    assert len(finished(store)) == 30


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_nobody_goes_on_alone(study, fake_mamo, did, tmp_path, number):
    """Not even a worker that hangs in C, nor what it has started."""
    path = study(seeds=[deeds.CHILD])
    process = fake_mamo("study", "run", path, "--store", tmp_path / "s.db", "--workers", "2")
    wait_until(lambda: len(did("pids")) == 2)
    pids = [int(word) for line in did("pids") for word in line.split()[1:]]
    assert all(is_running(pid) for pid in pids)
    process.send_signal(number)
    process.communicate(timeout=PATIENCE)
    wait_until(lambda: not any(is_running(pid) for pid in pids))


def test_a_second_run_is_refused(study, fake_mamo, did, tmp_path):
    path = study(seeds=[deeds.CHILD])
    arguments = ("study", "run", path, "--store", tmp_path / "s.db", "--workers", "1")
    first = fake_mamo(*arguments)
    wait_until(lambda: did("pids"))
    second = fake_mamo(*arguments)
    out, err = second.communicate(timeout=PATIENCE)
    assert (second.returncode, out) == (2, "")
    assert f"another 'mamo study run' (process {first.pid}) is writing to it" in err
    status = fake_mamo("study", "status", tmp_path / "s.db", "--json")  # reading is allowed
    out, _ = status.communicate(timeout=PATIENCE)
    assert '"total": 2,\n  "done": 0,' in out


def test_a_worker_that_is_killed_from_outside_costs_its_task(study, fake_mamo, did, tmp_path):
    path = study(seeds=[deeds.CHILD, 2])
    process = fake_mamo("study", "run", path, "--store", tmp_path / "s.db", "--workers", "1")
    for count in (1, 2):  # one for each problem
        wait_until(lambda count=count: len(did("pids")) == count)
        worker, child = map(int, did("pids")[-1].split()[1:])
        os.kill(worker, signal.SIGKILL)
        wait_until(lambda child=child: not is_running(child))
    assert process.wait(PATIENCE) == 0
    with closing(sqlite3.connect(tmp_path / "s.db")) as connection:
        found = connection.execute("SELECT seed, status, reason FROM results ORDER BY seed, 2")
        assert found.fetchall() == [
            *[(2, "solved", "")] * 2,
            *[(deeds.CHILD, "crashed", "the worker was ended by SIGKILL")] * 2,
        ]
