"""The scenes published with the thesis: what a record holds and how the raw text is read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NoReturn

from pydantic import Field

from mamo_core.config import Located, validated
from mamo_core.errors import InputError
from mamo_core.hookspecs import Options

SHELF_NAMES = {1: "base", 2: "back", 3: "top", 4: "right", 5: "left"}
"""Names of the shelf's boards by their number in the raw files."""

_BOX, _CYLINDER = 0, 2
_SHELF, _IMMOVABLE, _MOVABLE = -1, 0, 1
_COLUMNS = 15

Triple = list[float]


class Board(Options):
    """A shelf board: an axis-aligned box; ``pos`` its centre, ``size`` FULL extents, metres."""

    id: int
    name: str
    pos: Triple = Field(min_length=3, max_length=3)
    size: Triple = Field(min_length=3, max_length=3)
    mu: float


class Body(Options):
    """An object; a box has ``size`` (FULL extents, m), a cylinder ``radius`` and ``height`` (m)."""

    id: int
    shape: Literal["box", "cylinder"]
    pos: Triple = Field(min_length=3, max_length=3)
    yaw: float
    mass: float = Field(gt=0.0)
    mu: float = Field(gt=0.0)
    size: Triple | None = Field(default=None, min_length=3, max_length=3)
    radius: float | None = None
    height: float | None = None


class Pregrasp(Options):
    """Tool pose before the grasp: ``pos`` (m) and ``yaw`` (rad), roll = pitch = 0."""

    pos: Triple = Field(min_length=3, max_length=3)
    yaw: float


class ThesisScene(Options):
    """One published scene; ``ooi`` is the object of interest, the target."""

    id: int
    shelf: list[Board]
    ooi: Body
    immovables: list[Body]
    movables: list[Body]
    pregrasp: Pregrasp


def looks_raw(text: str) -> bool:
    """Whether the text is one of the author's ``plan_*_SCENE.txt`` files."""
    return text.lstrip().split("\n", 1)[0].strip() == "O"


def parse_raw(text: str, number: int, source: str) -> ThesisScene:
    """The scene in the text of ``plan_NNNNNN_SCENE.txt``; ``number`` is NNNNNN.

    Only the sections O (objects), G (pre-grasp) and ooi are read. Lengths there: boxes are half
    extents, cylinders radius twice and FULL height.

    Raises:
        InputError: a section is missing or cut short, or a value is not what it should be.
    """
    return _RawReader(text, source).scene(number)


class _RawReader:
    def __init__(self, text: str, source: str) -> None:
        self._lines = text.splitlines()
        self._source = source

    def scene(self, number: int) -> ThesisScene:
        shelf: list[Board] = []
        bodies: dict[int, list[Body]] = {_IMMOVABLE: [], _MOVABLE: []}
        for line in self._object_lines():
            fields = self._fields(line, _COLUMNS)
            kind = int(self._number(line, fields[2]))
            if kind == _SHELF:
                shelf.append(self._board(line, fields))
            elif kind in bodies:
                bodies[kind].append(self._body(line, fields))
            else:
                self._fail(line, f"type {kind}, expected -1 (shelf), 0 (immovable) or 1 (movable)")
        ooi_line = self._section("ooi")
        ooi = int(self._number(ooi_line, self._text(ooi_line)))
        chosen = [body for body in bodies[_IMMOVABLE] if body.id == ooi]
        if not chosen:
            valid = ", ".join(str(body.id) for body in bodies[_IMMOVABLE])
            self._fail(ooi_line, f"ooi {ooi} is no immovable object of the scene (valid: {valid})")
        return ThesisScene(
            id=number,
            shelf=shelf,
            ooi=chosen[0],
            immovables=[body for body in bodies[_IMMOVABLE] if body.id != ooi],
            movables=bodies[_MOVABLE],
            pregrasp=self._pregrasp(),
        )

    def _object_lines(self) -> Sequence[int]:
        first = self._section("O")
        count = int(self._number(first, self._text(first)))
        return range(first + 1, first + 1 + count)

    def _board(self, line: int, fields: list[str]) -> Board:
        ident, pos, half, mu = self._common(line, fields)
        if ident not in SHELF_NAMES:
            self._fail(line, f"shelf board {ident}, expected 1 to {len(SHELF_NAMES)}")
        size = [2.0 * h for h in half]
        return Board(id=ident, name=SHELF_NAMES[ident], pos=pos, size=size, mu=mu)

    def _body(self, line: int, fields: list[str]) -> Body:
        ident, pos, lengths, mu = self._common(line, fields)
        shape = int(self._number(line, fields[1]))
        yaw, mass = self._number(line, fields[8]), self._number(line, fields[12])
        data = {"id": ident, "pos": pos, "yaw": yaw, "mass": mass, "mu": mu}
        if shape == _BOX:
            data |= {"shape": "box", "size": [2.0 * half for half in lengths]}
        elif shape == _CYLINDER:
            data |= {"shape": "cylinder", "radius": lengths[0], "height": lengths[2]}
        else:
            self._fail(line, f"shape {shape}, expected 0 (box) or 2 (cylinder)")
        return validated(Body, Located(data, f"{self._source}:{line + 1}"))

    def _common(self, line: int, fields: list[str]) -> tuple[int, Triple, Triple, float]:
        """Number, centre, the three lengths as they stand there, friction."""
        pos = [self._number(line, f) for f in fields[3:6]]
        lengths = [self._number(line, f) for f in fields[9:12]]
        return int(self._number(line, fields[0])), pos, lengths, self._number(line, fields[13])

    def _pregrasp(self) -> Pregrasp:
        line = self._section("G")
        x, y, z, yaw, _, roll = (self._number(line, f) for f in self._fields(line, 6))
        # Roll pi is the other set of Euler angles of the same upright tool.
        turned = yaw + math.pi if abs(roll) >= 1e-4 else yaw
        return Pregrasp(pos=[x, y, z], yaw=turned)

    def _section(self, name: str) -> int:
        """Place of the first line after the section's heading."""
        for i, text in enumerate(self._lines):
            if text.strip() == name:
                return i + 1
        raise InputError(f"{self._source}: section {name!r} is missing; is the file cut short?")

    def _text(self, line: int) -> str:
        if line >= len(self._lines):
            self._fail(line, "the file ends here; is it cut short?")
        return self._lines[line].strip()

    def _fields(self, line: int, count: int) -> list[str]:
        fields = self._text(line).split(",")
        if len(fields) != count:
            self._fail(line, f"{len(fields)} values, expected {count}")
        return fields

    def _number(self, line: int, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            self._fail(line, f"{text!r}, expected a finite number")
        return value

    def _fail(self, line: int, message: str) -> NoReturn:
        raise InputError(f"{self._source}:{line + 1}: {message}")
