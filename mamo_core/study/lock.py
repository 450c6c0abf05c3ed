"""One writer for each store, as long as its process lives and no longer."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path
from types import TracebackType

from mamo_core.errors import InputError


class StoreLock:
    """Holds ``STORE.lock``; the system lets go of it with the process, however that ends."""

    def __init__(self, store: Path) -> None:
        self._store = store
        self._path = store.with_name(f"{store.name}.lock")
        self._file = -1

    def __enter__(self) -> StoreLock:
        try:
            self._file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise InputError(f"{self._store}: cannot be written: {error.strerror}") from None
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            owner = os.pread(self._file, 32, 0).decode(errors="replace").strip()
            os.close(self._file)
            raise InputError(
                f"{self._store}: another 'mamo study run' (process {owner}) is writing to it"
            ) from None
        os.ftruncate(self._file, 0)
        os.pwrite(self._file, f"{os.getpid()}\n".encode(), 0)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        os.close(self._file)
