"""Both ways to step the engine are measured, and the engine is left as it was."""

import pytest
import steps
from mamo_mujoco.engine import MuJoCoWorld


def test_ways_and_threads(capsys):
    own = MuJoCoWorld.follow
    assert steps.main(["--pushes", "1", "--repeats", "1"]) == 0
    assert MuJoCoWorld.follow is own
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert rows[0][:2] == ["steps", "threads"]
    assert [(" ".join(r[:-4]), r[-4]) for r in rows[1:]] == [
        ("one by one", "1"),
        ("one by one", "2"),
        ("compiled", "1"),
        ("compiled", "2"),
    ]
    assert all(float(r[-3]) > 0 and float(r[-2]) > 0 for r in rows[1:])


def test_what_the_engine_goes_on_by():
    own = MuJoCoWorld.follow
    with steps._driven("one by one"):
        assert MuJoCoWorld.follow is not own
    with steps._driven("compiled"):
        assert MuJoCoWorld.follow is own
    with pytest.raises(ZeroDivisionError), steps._driven("one by one"):
        raise ZeroDivisionError
    assert MuJoCoWorld.follow is own
