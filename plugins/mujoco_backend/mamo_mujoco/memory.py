"""Where the engine's memory has the contacts, for compiled code, which cannot ask the bindings."""

from __future__ import annotations

import ctypes
import math
from functools import cache
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
from mujoco.introspect.ast_nodes import ArrayType, PointerType
from mujoco.introspect.structs import STRUCTS

from mamo_core.errors import PluginError

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
    <body pos="0 0 0.1"><freejoint/><geom size="0.1"/></body>
    <body pos="0 0.5 0.12"><freejoint/><geom size="0.1"/></body>
    <body pos="0 0.65 0.14"><freejoint/><geom size="0.1"/></body>
  </worldbody>
</mujoco>
"""


def contacts_of(data: Any) -> tuple[CIntArray, CIntArray]:
    """How many there are (1,), and the geoms of all there is room for (m, 2), in ``data`` itself.

    Raises:
        PluginError: this version of MuJoCo has them elsewhere.
    """
    _check()
    return _views(data)


@cache
def _check() -> None:
    """Compare with what the bindings say, while balls fall and the contacts change."""
    model = mujoco.MjModel.from_xml_string(_BALLS)
    data = mujoco.MjData(model)
    count, geoms = _views(data)
    for _ in range(10):
        mujoco.mj_step(model, data)
        if count[0] != data.ncon or not np.array_equal(geoms[: data.ncon], data.contact.geom):
            raise PluginError(
                f"backend 'mujoco': MuJoCo {mujoco.__version__} does not keep its contacts where "
                "its own description says; install the version that mamo is tested with"
            )


def _views(data: Any) -> tuple[CIntArray, CIntArray]:
    """Contacts always lie at the beginning of the arena, which never moves."""
    layout, contact = _structure("mjData"), _structure("mjContact")
    here = layout.from_address(data._address)
    size, first = (n // ctypes.sizeof(ctypes.c_int) for n in _place(contact, "geom"))
    rows = here.narena // ctypes.sizeof(contact)
    words = (ctypes.c_int * (rows * size)).from_address(here.contact)
    count = (ctypes.c_int * 1).from_address(data._address + layout.ncon.offset)
    return (
        np.ctypeslib.as_array(count),
        np.ctypeslib.as_array(words).reshape(rows, size)[:, first : first + 2],
    )


def _place(structure: Any, field: str) -> tuple[int, int]:
    return ctypes.sizeof(structure), getattr(structure, field).offset


@cache
def _structure(name: str) -> Any:
    """A structure of the engine, as it describes itself."""
    fields = [(field.name, _type(field.type)) for field in STRUCTS[name].fields]
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def _type(kind: Any) -> Any:
    if isinstance(kind, PointerType):
        return ctypes.c_void_p
    if isinstance(kind, ArrayType):
        return _type(kind.inner_type) * math.prod(kind.extents)
    return _structure(kind.name) if kind.name in STRUCTS else _PLAIN[kind.name]
