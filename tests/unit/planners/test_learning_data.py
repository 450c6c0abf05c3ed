"""What was gathered survives any end of a run, and nothing stands there twice."""

import json
from dataclasses import replace

import pytest
from mamo_planners.learning.data import Explored, Point, Settings, open_data
from mamo_planners.search.features import Features

from mamo_core.errors import InputError

SETTINGS = Settings(3, (5, 10), ("easy",), 4, 20, 5, 60.0)
POINT = Point(3, 0, 0, Features(0.1, 2, (0.25, 0.5)), True)


@pytest.fixture
def path(tmp_path):
    file = tmp_path / "data.jsonl"
    with open_data(file, SETTINGS) as data:
        data.add(Explored(3, "shelf", 2))
        data.add(POINT)
    return file


def test_what_was_written_is_read_again(path):
    with open_data(path, SETTINGS) as data:
        assert data.points == {(3, 0): POINT}
        assert data.explored == {3: Explored(3, "shelf", 2)}
        assert not data.complete(3)
        assert not data.complete(4)
        data.add(replace(POINT, vertex=1))
        assert data.complete(3)
    assert len(path.read_text().splitlines()) == 4


def test_nothing_is_added_twice(path):
    with open_data(path, SETTINGS) as data:
        for item in (POINT, Explored(3, "shelf", 2)):
            with pytest.raises(ValueError, match="twice"):
                data.add(item)
    assert len(path.read_text().splitlines()) == 3


def test_every_line_is_json(path):
    first, second, third = map(json.loads, path.read_text().splitlines())
    assert (first["schema_version"], first["kind"], first["movables"]) == (1, "settings", [5, 10])
    assert (second["kind"], second["problem"], second["vertices"]) == ("problem", 3, 2)
    assert third["kind"] == "point"
    assert (third["occupied"], third["count"], third["efforts"]) == (0.1, 2, [0.25, 0.5])


@pytest.mark.parametrize("kept", [1, 10, -1, -20])
def test_a_line_that_was_being_written_is_done_again(path, kept):
    text = path.read_bytes()
    *whole, last = text.splitlines(keepends=True)
    path.write_bytes(b"".join(whole) + last[:kept])
    with open_data(path, SETTINGS) as data:
        assert data.points == {}
        data.add(POINT)
    assert path.read_bytes() == text


def test_a_first_line_that_was_being_written(path):
    text = path.read_bytes()
    path.write_bytes(text[:30])
    with open_data(path, SETTINGS) as data:
        assert data.explored == {}
    assert path.read_bytes() == text.splitlines(keepends=True)[0]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("nonsense\n", r":1: is not a line of gathered data"),
        ("[]\n", r":1: is not a line of gathered data"),
        ('{"kind": "settings", "schema_version": 9}\n', r"no data of this version \(expected 1\)"),
    ],
)
def test_other_files_are_refused(path, text, expected):
    path.write_text(text)
    with pytest.raises(InputError, match=expected), open_data(path, SETTINGS):
        pass
    assert path.read_text() == text


@pytest.mark.parametrize(
    "line",
    [
        '{"kind": "point", "problem": 3}',
        '{"kind": "pint", "problem": 3}',
        '{"kind": "problem", "problem": 3, "name": "shelf", "vertices": 2}',
        '{"problem": 3}',
    ],
)
def test_broken_lines_are_named(path, line):
    with path.open("a") as file:
        file.write(line + "\n")
    with pytest.raises(InputError, match=r"data\.jsonl:4: "), open_data(path, SETTINGS):
        pass


def test_other_settings_are_refused(path):
    other = replace(SETTINGS, movables=(5, 15))
    expected = r"was gathered with movables \[5, 10\], not \[5, 15\]"
    with pytest.raises(InputError, match=expected), open_data(path, other):
        pass


def test_one_process_writes(path):
    with (
        open_data(path, SETTINGS),
        pytest.raises(InputError, match="another process is writing"),
        open_data(path, SETTINGS),
    ):
        pass
