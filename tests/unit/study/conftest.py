"""Studies whose workers only pretend."""

import os
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # workers get our path, and with it study_deeds

from mamo_core.problems import generate_shelf, save_problems  # noqa: E402
from mamo_core.study.local import LocalExecutor  # noqa: E402
from mamo_core.study.run import StudyOrder, run_study  # noqa: E402
from mamo_core.study.store import open_store  # noqa: E402

STUDY = """\
schema_version: 1
name: pretence
problems: [few.jsonl]
recipes: [m4m]
seeds: {seeds}
budget: 5
deadline: {deadline}
"""


@pytest.fixture
def study(tmp_path):
    """``study(seeds=[...], ...)`` writes a study of two problems; the path of its file."""
    problems = [generate_shelf(movables=1, seed=seed) for seed in (1, 2)]
    save_problems(problems, tmp_path / "few.jsonl")

    def write(seeds=(0,), deadline=60.0, more=""):
        path = tmp_path / "study.yaml"
        path.write_text(STUDY.format(seeds=list(seeds), deadline=deadline) + more)
        return path

    return write


@pytest.fixture
def run(tmp_path, monkeypatch):
    """``run(study, ...)`` does a study here, with workers that pretend; status and told lines."""
    from fake_mamo import WORK
    from study_deeds import LOG

    monkeypatch.setenv(LOG, str(tmp_path / "log"))

    def run(path, tell=None, **options):
        told = []
        options = {"store": tmp_path / "s.db", "workers": 1, **options}
        status = run_study(StudyOrder(path, **options), tell or told.append, WORK)
        return status, told

    return run


@pytest.fixture
def rows(tmp_path):
    """``rows()`` of the store of ``run``."""

    def read(name="s.db"):
        with open_store(tmp_path / name) as store:
            return store.rows()

    return read


@pytest.fixture
def did(tmp_path):
    """``did("solve")``: the lines with that first word that workers have noted."""

    def read(word):
        path = tmp_path / "log"
        lines = path.read_text().splitlines() if path.exists() else []
        return [line for line in lines if line.split()[0] == word]

    return read


@pytest.fixture
def fake_mamo(tmp_path):
    """``fake_mamo("study", ...)`` starts the command with workers that pretend."""
    from study_deeds import LOG

    started = []
    environment = {**os.environ, LOG: str(tmp_path / "log"), "PYTHONPATH": str(HERE)}

    def start(*arguments):
        command = [sys.executable, str(HERE / "fake_mamo.py"), *map(str, arguments)]
        process = subprocess.Popen(
            command,
            cwd=tmp_path,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


@pytest.fixture
def executor():
    """One worker of this machine."""
    with closing(LocalExecutor(1)) as made:
        yield made
