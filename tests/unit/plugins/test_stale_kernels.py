"""What was compiled before a kernel changed is not used again."""

import os
import subprocess
import sys

import pytest

from mamo_core.stale_kernels import forget_stale_kernels, package_folders

CALLED = "from numba import njit\n\n\n@njit(cache=True)\ndef value():\n    return {}\n"
CALLER = (
    "from numba import njit\n\nfrom called import value\n\n\n"
    "@njit(cache=True)\ndef twice():\n    return 2 * value()\n"
)


@pytest.fixture
def kernels(tmp_path):
    (tmp_path / "called.py").write_text(CALLED.format(1))
    (tmp_path / "caller.py").write_text(CALLER)
    return tmp_path


def twice(folder):
    command = [sys.executable, "-c", "import caller; print(caller.twice())"]
    environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=True
    )
    return int(done.stdout)


def test_a_kernel_that_calls_a_changed_one_is_compiled_anew(kernels):
    assert twice(kernels) == 2
    assert forget_stale_kernels([kernels]) == 0
    (kernels / "called.py").write_text(CALLED.format(30))
    later = max(file.stat().st_mtime for file in kernels.rglob("*.nb?")) + 1.0
    os.utime(kernels / "called.py", (later, later))
    assert forget_stale_kernels([kernels]) == len(["called", "caller"]) * len(["index", "code"])
    assert twice(kernels) == 60


def test_other_files_do_not_count(kernels):
    compiled = kernels / "__pycache__" / "called.value-5.py311.nbi"
    compiled.parent.mkdir()
    compiled.touch()
    os.utime(kernels / "called.py", (1.0, 1.0))
    os.utime(compiled, (2.0, 2.0))
    assert forget_stale_kernels([kernels]) == 0  # caller.py is newer, but has nothing compiled
    assert compiled.exists()


def test_packages_that_are_not_there_have_no_folder():
    assert package_folders(["no_such_package.plugin", "os"]) == []
    assert [folder.name for folder in package_folders(["mamo_core.plugins"])] == ["mamo_core"]
