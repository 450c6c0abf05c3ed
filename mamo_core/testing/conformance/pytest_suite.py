"""The checks as tests of a plugin.

::

    from mamo_core.testing.conformance.pytest_suite import BackendConformance

    class TestMyEngine(BackendConformance):
        backend = "my_engine"
"""

from __future__ import annotations

import pytest

from mamo_core.plugins import discover
from mamo_core.testing.conformance.runner import Verdict, bench_of, run_check
from mamo_core.testing.conformance.table import CHECKS, Check


class BackendConformance:
    """Pytest collects it through your subclass; each check is a test."""

    backend: str
    """Name under which the backend is registered."""

    @pytest.mark.parametrize("check", CHECKS, ids=[check.name for check in CHECKS])
    def test_conformance(self, check: Check) -> None:
        component = discover().component("backend", self.backend, type(self).__name__)
        report = run_check(check, bench_of(component), component)
        if report.verdict is Verdict.DECLARED_UNSUPPORTED:
            pytest.skip(f"not declared: {report.message}")
        if report.verdict is Verdict.KNOWN_GAP:
            pytest.xfail(report.message)
        assert report.verdict is Verdict.PASSED, report.message
