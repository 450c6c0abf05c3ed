"""Where the engine's memory has the contacts, for compiled code, which cannot ask the bindings."""

from __future__ import annotations

import ctypes
import math
from functools import cache
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
from mujoco.introspect.ast_nodes import ArrayType, PointerType, ValueType
from mujoco.introspect.structs import STRUCTS

from mamo_core.errors import PluginError
from mamo_core.types.geometry import Array

CIntArray = npt.NDArray[np.intc]

_PLAIN: dict[str, Any] = {
    "int": ctypes.c_int,
    "float": ctypes.c_float,
    "mjtBool": ctypes.c_uint8,
    "mjtNum": ctypes.c_double,
    "mjtSize": ctypes.c_int64,
    "size_t": ctypes.c_size_t,
    "uint64_t": ctypes.c_uint64,
    "uintptr_t": ctypes.c_size_t,
}
_BALLS = """
<mujoco>
  <option timestep="0.01"/>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body pos="0 0 0.099"><freejoint/><geom size="0.1"/></body>
    <body pos="0 0.5 0.12"><freejoint/><geom size="0.1"/></body>
    <body pos="0 0.65 0.14"><freejoint/><geom size="0.1"/></body>
  </worldbody>
</mujoco>
"""


def contacts_of(data: Any) -> tuple[CIntArray, CIntArray, Array]:
    """How many there are (1,), and geoms (m, 2) and distances (m,) of all there is room for.

    All lie in ``data`` itself.

    Raises:
        PluginError: this version of MuJoCo has them elsewhere.
    """
    _check()
    here, contact = _here(data), _structure("mjContact")
    size, first = _words(ctypes.sizeof(contact)), _words(contact.geom.offset)
    rows = here.narena // ctypes.sizeof(contact)
    count = (ctypes.c_int * 1).from_address(data._address + type(here).ncon.offset)
    words = (ctypes.c_int * (rows * size)).from_address(here.contact)
    geoms = np.ctypeslib.as_array(words).reshape(rows, size)[:, first : first + 2]
    bytes_ = np.ctypeslib.as_array(words).reshape(rows, size)
    distances = bytes_[:, _words(contact.dist.offset) :][:, :2].view(np.float64)[:, 0]
    return np.ctypeslib.as_array(count), geoms, distances


@cache
def _check() -> None:
    """Compare with what the bindings say, while balls fall and the number of contacts changes.

    Contacts lie at the beginning of the arena, which never moves.
    """
    data = mujoco.MjData(model := mujoco.MjModel.from_xml_string(_BALLS))
    begin, contact = _here(data).contact, _structure("mjContact")
    for _ in range(10):
        mujoco.mj_step(model, data)
        here, geoms = _here(data), data.contact.geom
        found = here.narena, here.ncon, begin + contact.geom.offset, ctypes.sizeof(contact)
        if found != (data.narena, data.ncon, geoms.ctypes.data, geoms.strides[0]):
            raise _unknown("does not have its contacts where its own description says")


def _unknown(what: str) -> PluginError:
    return PluginError(
        f"backend 'mujoco': MuJoCo {mujoco.__version__} {what}; "
        "install the version in mamo's constraints.txt"
    )


def _words(size: int) -> int:
    return size // ctypes.sizeof(ctypes.c_int)


def _here(data: Any) -> Any:
    """The engine's structure behind ``data``."""
    return _structure("mjData").from_address(data._address)


@cache
def _structure(name: str) -> Any:
    """A structure of the engine, as it describes itself."""
    fields = [(field.name, _type(field.type)) for field in STRUCTS[name].fields]
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def _type(kind: Any) -> Any:
    if isinstance(kind, PointerType):
        return ctypes.c_size_t
    if isinstance(kind, ArrayType):
        return _type(kind.inner_type) * math.prod(kind.extents)
    if isinstance(kind, ValueType) and kind.name in STRUCTS:
        return _structure(kind.name)
    if isinstance(kind, ValueType) and kind.name in _PLAIN:
        return _PLAIN[kind.name]
    raise _unknown(f"describes a type that mamo does not know: {kind}")
