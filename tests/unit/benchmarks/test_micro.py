"""The micro benchmark: its targets and table, and every measurement in small."""

import json
from itertools import islice

import micro
import pytest
from measures import arm, collision, mapf, push, startup
from measures.common import initial_region, shelves

from mamo_core.plugins import discover

KEYS = {
    "config_checks_per_s",
    "checks_vs_fcl",
    "missed_collisions",
    "arm_plan_ms_median",
    "mapf10_ms_median",
    "mapf15_ms_p95",
    "push_cpu_s",
    "compile_s",
    "help_s",
}


@pytest.fixture(scope="module")
def registry():
    return discover()


def test_targets():
    assert set(micro.TARGETS) == KEYS
    rate, misses = micro.TARGETS["checks_vs_fcl"], micro.TARGETS["missed_collisions"]
    assert (rate.met(50), rate.met(49.9), misses.met(0), misses.met(1)) == (
        True,
        False,
        True,
        False,
    )
    assert (str(rate), str(misses)) == (">= 50", "<= 0")


def test_table_and_document(tmp_path, monkeypatch, capsys):
    values = dict.fromkeys(KEYS, 0.25)
    how = dict.fromkeys(KEYS, "guessed")
    monkeypatch.setattr(micro, "measure_all", lambda: (values, how))
    assert micro.main(["--json", str(tmp_path / "m.json")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2 + len(KEYS)
    assert [c.strip() for c in lines[-1].split("|")[1:-1]] == [
        "mamo --help",
        "0.25 s",
        "<= 0.5 s",
        "yes",
        "guessed",
    ]
    document = json.loads((tmp_path / "m.json").read_text())
    assert {key: document[key] for key in KEYS} == values
    assert document["met"]["missed_collisions"] is False


def test_shelves_have_as_many_objects_as_they_say(registry):
    (context,) = islice(shelves(registry, collision.MOVABLES, ("collision",)), 1)
    assert len(context.problem.scene.objects) == 20
    (context,) = islice(shelves(registry, push.MOVABLES, mapf.ROLES), 1)
    assert len(context.problem.scene.objects) == 15
    assert initial_region(context) is not None


def test_collision(registry, monkeypatch):
    monkeypatch.setattr(collision, "CONFIGURATIONS", 200)
    monkeypatch.setattr(collision, "SCENES", 1)
    measured = collision.measure(registry)
    assert measured.values["missed_collisions"] == 0
    assert measured.values["checks_vs_fcl"] > 1.0
    assert measured.how["config_checks_per_s"].startswith("400 configurations")


def test_arm(registry, monkeypatch):
    monkeypatch.setattr(arm, "QUERIES", 2)
    assert 0.0 < arm.measure(registry).values["arm_plan_ms_median"] < 1000.0


def test_mapf(registry, monkeypatch):
    monkeypatch.setattr(mapf, "INSTANCES", {10: 1, 15: 1})
    assert set(mapf.measure(registry).values) == {"mapf10_ms_median", "mapf15_ms_p95"}


def test_push(registry, monkeypatch):
    monkeypatch.setattr(push, "PUSHES", 1)
    assert 0.0 < push.measure(registry).values["push_cpu_s"] < 5.0


def test_help(monkeypatch):
    monkeypatch.setattr(startup, "REPEATS", 1)
    assert 0.0 < startup.measure_help().values["help_s"] < 30.0
