"""Every transition model of ours keeps what the conformance suite asks for."""

from __future__ import annotations

import pytest

from mamo_core.testing.conformance.fake_bench import quasi_static_bench
from mamo_core.testing.conformance.pytest_suite import BackendConformance
from mamo_core.testing.conformance.table import CHECKS, Check

FAKE = quasi_static_bench()
FOR_THE_FAKE = [c for c in CHECKS if c.needs is None or c.needs in FAKE.capabilities]


class TestMuJoCo(BackendConformance):
    backend = "mujoco"


class TestPyBullet(BackendConformance):
    backend = "pybullet"


class TestDART(BackendConformance):
    backend = "dart"


@pytest.mark.parametrize("check", FOR_THE_FAKE, ids=lambda check: check.name)
def test_quasi_static(check: Check) -> None:
    check.run(FAKE)
