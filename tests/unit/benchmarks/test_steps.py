"""Both ways to step the engine are measured, and the engine is left as it was."""

import steps
from mamo_mujoco.engine import MuJoCoWorld


def test_ways_and_threads(capsys):
    own = MuJoCoWorld.follow
    assert steps.main(["--pushes", "1", "--repeats", "1"]) == 0
    assert MuJoCoWorld.follow is own
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert rows[0][:3] == ["steps", "threads", "us/step"]
    found = {(" ".join(row[:-5]), row[-5]): float(row[-3]) for row in rows[1:]}
    assert set(found) == {(way, n) for way in ("one by one", "compiled") for n in "12"}
    assert found["one by one", "1"] == found["one by one", "2"] == 1.0
    assert found["compiled", "1"] == found["compiled", "2"] > 10.0
