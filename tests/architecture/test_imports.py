"""What may import what, and what must not be imported to answer ``mamo --help``."""

import subprocess
import sys
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[2]
PLUGINS = (
    "mamo_dart",
    "mamo_geometry",
    "mamo_mujoco",
    "mamo_ompl",
    "mamo_planners",
    "mamo_pybullet",
)
PLUGIN_API = {
    f"mamo_core.{name}"
    for name in (
        "constraints",
        "errors",
        "hookspecs",
        "interfaces",
        "robots",
        "simulation",
        "types",
    )
}
SLOW = (
    "mujoco",
    "pybullet",
    "dartpy",
    "pebble",
    "numba",
    "numpy",
    "pinocchio",
    "fcl",
    "trimesh",
    "scipy",
    "matplotlib",
    "pydantic",
    "ruamel",
    "pluggy",
)


def imported_by(code):
    """Top-level modules in ``sys.modules`` after running ``code`` in a new process."""
    code = f"{code}\nimport sys\nprint(*sorted({{name.split('.')[0] for name in sys.modules}}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())


@pytest.mark.parametrize(
    "code",
    [
        "import mamo_core.cli.main",
        """
from mamo_core.cli.main import main
try:
    main(["--help"])
except SystemExit:
    pass
""",
    ],
)
def test_help_imports_nothing_slow(code):
    assert imported_by(code) & set(SLOW) == set()


def test_discovery_loads_no_engine_and_no_compiler():
    loaded = imported_by("from mamo_core.plugins import discover; discover()")
    assert (
        loaded
        & {
            "dartpy",
            "mujoco",
            "numba",
            "ompl",
            "pybullet",
            "pinocchio",
            "fcl",
            "trimesh",
            "matplotlib",
        }
        == set()
    )


def test_contracts_of_import_linter():
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command as l; l()"]
    done = subprocess.run(
        [*command, "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_plugins_know_only_a_part_of_the_core():
    graph = grimp.build_graph(
        "mamo_core", *PLUGINS, exclude_type_checking_imports=True, cache_dir=None
    )
    for plugin in PLUGINS:
        for module in {plugin, *graph.find_descendants(plugin)}:
            used = graph.find_modules_directly_imported_by(module)
            core = {".".join(name.split(".")[:2]) for name in used if name.startswith("mamo_core")}
            assert core <= PLUGIN_API, f"{module} imports {sorted(core - PLUGIN_API)}"
