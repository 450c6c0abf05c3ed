"""What every physics backend must do: one list of checks, run by hand or by pytest.

``mamo plugins check NAME`` runs them on a registered backend; ``pytest_suite.BackendConformance``
runs them among the tests of a plugin.
"""
