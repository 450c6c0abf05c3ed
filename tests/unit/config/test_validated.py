"""Mistakes in documents: place, key, value and what is expected, one sentence each."""

from enum import StrEnum
from typing import Annotated, Literal

import pytest
from pydantic import Field, model_validator

from mamo_core.config import load_model, load_text, validated
from mamo_core.errors import InputError
from mamo_core.hookspecs import Options


class Color(StrEnum):
    RED = "red"
    BLUE = "blue"


class Box(Options):
    box: tuple[float, float, float]


class Cylinder(Options):
    radius: Annotated[float, Field(gt=0.0)]
    height: float = 1.0


class Thing(Options):
    name: str = Field(min_length=1, pattern="^[a-z]+$")
    mass: float = Field(gt=0.0)
    shape: Box | Cylinder | None = None
    kind: Literal["movable", "immovable"] = "movable"
    color: Color | None = None
    count: int = Field(default=1, ge=1, le=9)

    @model_validator(mode="after")
    def _red_is_light(self) -> "Thing":
        if self.color is Color.RED and self.mass > 1.0:
            raise ValueError("red things are light")
        return self


class Document(Options):
    things: tuple[Thing, ...] = Field(default=(), max_length=3)
    table: dict[str, Cylinder] = Field(default_factory=dict)
    flag: bool = False


def complaint(text):
    with pytest.raises(InputError) as caught:
        validated(Document, load_text(text, "f"))
    return str(caught.value)


def test_valid():
    text = "things:\n- {name: a, mass: 1, shape: {box: [1, 2, 3]}, color: blue}\nflag: true\n"
    document = validated(Document, load_text(text, "f"))
    assert document.things[0].shape == Box(box=(1.0, 2.0, 3.0))
    assert document.things[0].color is Color.BLUE


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "flog: true",
            "f:1:1: unknown key 'flog'; did you mean 'flag'? (valid: flag, table, things)",
        ),
        ("zzz: true", "f:1:1: unknown key 'zzz' (valid: flag, table, things)"),
        ("flag: yes", "f:1:7: flag: 'yes', expected true or false"),
        ("flag: 1", "f:1:7: flag: 1, expected true or false"),
        ("[1]", "f:1:1: [1], expected a mapping"),
        ("things: 3", "f:1:9: things: 3, expected a list"),
        ("table: [1]", "f:1:8: table: [1], expected a mapping"),
        ("table: {a: {radius: 0}}", "f:1:21: table.a.radius: 0, expected a number above 0"),
        (
            "table: {a: {radios: 1, radius: 1}}",
            "f:1:13: unknown key 'table.a.radios'; did you mean 'radius'? (valid: height, radius)",
        ),
    ],
)
def test_mistakes(text, expected):
    assert complaint(text) == expected


@pytest.mark.parametrize(
    ("thing", "expected"),
    [
        ("mass: 1", "f:2:3: things.0: missing key 'name'"),
        ("name: a, mass: .nan", "f:2:19: things.0.mass: nan, expected a finite number"),
        ("name: a, mass: .inf", "f:2:19: things.0.mass: inf, expected a finite number"),
        ("name: a, mass: -1", "f:2:19: things.0.mass: -1, expected a number above 0"),
        ("name: a, mass: '1'", "f:2:19: things.0.mass: '1', expected a number"),
        ("name: a, mass: true", "f:2:19: things.0.mass: true, expected a number"),
        ("name: a, mass: null", "f:2:19: things.0.mass: null, expected a number"),
        ("name: a, mass: {b: 1}", "f:2:19: things.0.mass: a mapping, expected a number"),
        ("name: 3, mass: 1", "f:2:10: things.0.name: 3, expected text"),
        ("name: '', mass: 1", "f:2:10: things.0.name: '', expected text of at least 1 characters"),
        ("name: A, mass: 1", "f:2:10: things.0.name: 'A', expected text like ^[a-z]+$"),
        ("name: a, mass: 1, count: 1.5", "f:2:29: things.0.count: 1.5, expected a whole number"),
        (
            "name: a, mass: 1, count: 0",
            "f:2:29: things.0.count: 0, expected a number of at least 1",
        ),
        (
            "name: a, mass: 1, count: 10",
            "f:2:29: things.0.count: 10, expected a number of at most 9",
        ),
        (
            "name: a, mass: 1, kind: fixed",
            "f:2:28: things.0.kind: 'fixed', expected 'movable' or 'immovable'",
        ),
        (
            "name: a, mass: 1, color: pink",
            "f:2:29: things.0.color: 'pink', expected 'red' or 'blue'",
        ),
        ("name: a, mass: 2, color: red", "f:2:3: things.0: red things are light"),
        (
            "name: a, mass: 1, shape: {radius: -1}",
            "f:2:38: things.0.shape.radius: -1, expected a number above 0",
        ),
        (
            "name: a, mass: 1, shape: {box: [1, 2]}",
            "f:2:35: things.0.shape.box: 2 items, expected more",
        ),
        (
            "name: a, mass: 1, shape: {radius: 1, hight: 1}",
            "f:2:41: unknown key 'things.0.shape.hight'; did you mean 'height'? "
            "(valid: box, height, radius)",
        ),
        ("name: a, mass: 1, shape: 7", "f:2:29: things.0.shape: 7, expected a mapping"),
    ],
)
def test_mistakes_in_a_list(thing, expected):
    assert complaint(f"things:\n- {{{thing}}}\n") == expected


def test_several_mistakes_take_a_line_each():
    lines = complaint("things:\n- {name: 1, mass: 0}\n- {nam: a, mass: 1}\n").splitlines()
    assert lines == [
        "f:2:10: things.0.name: 1, expected text",
        "f:2:19: things.0.mass: 0, expected a number above 0",
        "f:3:3: things.1: missing key 'name'",
        "f:3:4: unknown key 'things.1.nam'; did you mean 'name'? "
        "(valid: color, count, kind, mass, name, shape)",
    ]


def test_long_values_are_cut():
    assert len(complaint(f"flag: {'x' * 500}")) < 120


def test_too_many():
    thing = "{name: a, mass: 1}"
    text = f"things: [{thing}, {thing}, {thing}, {thing}]"
    assert complaint(text).endswith("expected at most 3 items, there are more")


def test_load_model(tmp_path):
    path = tmp_path / "d.yaml"
    path.write_text("flag: true\n")
    assert load_model(Document, path).flag
    path.write_text("flag: 2\n")
    with pytest.raises(InputError) as caught:
        load_model(Document, path)
    assert str(caught.value) == f"{path}:1:7: flag: 2, expected true or false"


def test_a_part_of_a_document_keeps_its_place():
    located = load_text("thing:\n  flag: 3\n  name: x\n", "f").at("thing").without("name")
    with pytest.raises(InputError) as caught:
        validated(Document, located)
    assert str(caught.value) == "f:2:9: thing.flag: 3, expected true or false"


def test_wrong_items_do_not_make_a_list_too_short():
    class Listed(Options):
        things: tuple[Thing, ...] = Field(min_length=1)

    with pytest.raises(InputError) as caught:
        validated(Listed, load_text("things: [{name: a}]", "f"))
    assert str(caught.value) == "f:1:10: things.0: missing key 'mass'"
    with pytest.raises(InputError, match="expected at least 1 items, there are 0"):
        validated(Listed, load_text("things: []", "f"))
