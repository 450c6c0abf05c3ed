"""Compiled kernels that are older than what they were made of."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

_COMPILED = "__pycache__/*.nb[ic]"


def forget_stale_kernels(folders: Iterable[Path]) -> int:
    """Delete what numba compiled before one of the kernels changed; how many files that were.

    numba compiles a kernel anew if its own file changes, but not if one changes that it calls: it
    would go on with the old one, and the same seed would give another plan than on a machine that
    compiled everything today. So whatever is older than the newest file with kernels goes, in all
    ``folders`` of packages. Caches elsewhere (``NUMBA_CACHE_DIR``) are left alone.
    """
    compiled = [file for folder in folders for file in folder.rglob(_COMPILED)]
    sources = {file.parent.parent / f"{file.name.split('.')[0]}.py" for file in compiled}
    newest = max((_changed(source) for source in sources), default=0.0)
    stale = [file for file in compiled if _changed(file) < newest]
    for file in stale:
        # Another process removed it, or the folder is not ours: then numba keeps its own elsewhere.
        with suppress(FileNotFoundError, PermissionError):
            file.unlink()
    return len(stale)


def package_folders(modules: Iterable[str]) -> list[Path]:
    """Folders of the packages that hold ``modules``, as far as there are any."""
    folders: list[Path] = []
    for name in sorted({module.split(".")[0] for module in modules}):
        with suppress(ImportError, ValueError):  # of plugins that are broken: told when they load
            spec = find_spec(name)
            folders += map(Path, (spec and spec.submodule_search_locations) or ())
    return folders


def _changed(file: Path) -> float:
    """When a file was changed; 0 if another process has removed it."""
    try:
        return file.stat().st_mtime
    except FileNotFoundError:
        return 0.0
