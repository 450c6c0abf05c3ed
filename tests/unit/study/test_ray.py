"""Two Ray nodes on this machine do what one process does, whatever crashes."""

import os
import shutil
import tempfile
from pathlib import Path

import pytest
import study_deeds as deeds

HERE = Path(__file__).parent
SMALL = {"num_cpus": 1, "object_store_memory": 80_000_000}


@pytest.fixture
def cluster(run, monkeypatch):
    """Two nodes with a core each; ``RAY_ADDRESS`` names them, ``run`` has set their environment."""
    folder = Path(tempfile.mkdtemp(prefix="r", dir="/tmp"))  # sockets: short paths only
    (folder / "ray").mkdir()
    monkeypatch.setenv("RAY_TMPDIR", str(folder))
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")]))
    from ray.cluster_utils import Cluster

    made = Cluster(initialize_head=True, head_node_args={**SMALL, "include_dashboard": False})
    try:
        made.second = made.add_node(**SMALL)
        monkeypatch.setenv("RAY_ADDRESS", made.address)
        yield made
    finally:
        made.shutdown()
        shutil.rmtree(folder, ignore_errors=True)


def test_same_rows_and_no_loss_with_a_node(cluster, study, run, rows, did, tmp_path):
    """One test for both, since a cluster takes long to start."""
    import ray

    path = study(seeds=[0, 1, deeds.ABORT, deeds.CHILD, deeds.FAIL, 2], deadline=2.0)
    run(path, workers=2)
    status, _ = run(path, store=tmp_path / "ray.db", executor="ray", workers=None)
    assert (status["total"], status["done"], status["failed"]) == (12, 12, 6)
    assert comparable(rows("ray.db")) == comparable(rows())
    assert not ray.is_initialized()
    assert len(did("pids")) == 4
    assert not any(is_running(pid) for line in did("pids") for pid in line.split()[1:])

    def lose_a_node(line):
        if line.startswith("[2/"):
            cluster.remove_node(cluster.second)

    path = study(seeds=range(6), deadline=60.0)
    run(path, store=tmp_path / "again.db", executor="ray", workers=2, tell=lose_a_node)
    run(path, store=tmp_path / "local.db")
    assert [row.status for row in rows("again.db")] == ["solved", "budget_exhausted"] * 6
    assert comparable(rows("again.db")) == comparable(rows("local.db"))


def is_running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def comparable(found):
    return [{k: v for k, v in vars(row).items() if k not in deeds.SECONDS} for row in found]
