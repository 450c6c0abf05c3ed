"""Workers crash and hang: each time that is the outcome of one job, and the next one goes on."""

import os
import signal

import pytest

from mamo_core.errors import PluginError
from mamo_core.study.jobs import Call, Failure, Job
from mamo_core.study.local import LocalExecutor


def job(deed, key="a", deadline=60.0, ready=None, **arguments):
    return Job(key, Call(f"study_deeds:{deed}", arguments), deadline, ready)


@pytest.mark.parametrize(
    ("deed", "failure", "cause"),
    [
        ("abort", Failure.CRASHED, "the worker was ended by SIGABRT"),
        ("segfault", Failure.CRASHED, "the worker was ended by SIGSEGV"),
        ("kill", Failure.CRASHED, "the worker was ended by SIGKILL"),
        ("leave", Failure.CRASHED, "the worker ended with exit code 3"),
        ("fail", Failure.ERROR, "TimeoutError: no luck"),
    ],
)
def test_a_job_fails_alone(executor, deed, failure, cause):
    first, second = executor.run([job(deed, "a"), job("echo", "b", value=7)])
    assert (first.key, first.failure, first.cause) == ("a", failure, cause)
    assert (second.key, second.failure, second.value) == ("b", None, 7)


def test_a_hang_in_c_ends_at_the_deadline(executor):
    first, second = executor.run([job("hang", "a", 0.5), job("echo", "b", value=7)])
    assert (first.failure, first.cause) == (Failure.TIMEOUT, "no answer for 0.5 s")
    assert second.value == 7


def test_a_worker_stays_for_its_next_jobs(executor):
    pids = {outcome.value for outcome in executor.run([job("pid", str(i)) for i in range(3)])}
    assert len(pids) == 1
    assert os.getpid() not in pids


def test_a_worker_that_is_killed_while_it_waits_costs_nothing(executor):
    (first,) = executor.run([job("pid")])
    os.kill(first.value, signal.SIGKILL)
    (second,) = executor.run([job("echo", value=7)])
    assert (second.failure, second.value) == (None, 7)


def test_it_gets_ready_once_for_each_readiness(executor, tmp_path, monkeypatch):
    monkeypatch.setenv("STUDY_DEEDS_LOG", str(tmp_path / "log"))
    first, second = (Call("study_deeds:note", {"text": text}) for text in ("one", "two"))
    jobs = [job("echo", str(i), ready=ready) for i, ready in enumerate((first, first, second))]
    assert all(outcome.failure is None for outcome in executor.run(jobs))
    assert (tmp_path / "log").read_text().split() == ["one", "two"]


def test_the_deadline_begins_when_it_is_ready(executor):
    slow = Call("study_deeds:slow", {"seconds": 1.0})
    (outcome,) = executor.run([job("echo", deadline=0.5, ready=slow, value=7)])
    assert outcome.value == 7


def test_what_cannot_get_ready_is_told_apart(executor):
    crash, refuse = Call("study_deeds:abort"), Call("study_deeds:refuse")
    first, second = executor.run([job("echo", ready=crash), job("echo", ready=refuse)])
    assert first.failure is Failure.CRASHED
    assert first.cause == "getting ready: the worker was ended by SIGABRT"
    assert isinstance(second.refused, PluginError)
    assert second.cause == "getting ready: PluginError: there is no such engine"


def test_one_thread_each(executor):
    names = ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"]
    (outcome,) = executor.run([job("environment", names=names)])
    assert outcome.value == dict.fromkeys(names, "1")


def test_no_jobs_start_no_worker():
    executor = LocalExecutor(2)
    assert list(executor.run([])) == []
    executor.close()
