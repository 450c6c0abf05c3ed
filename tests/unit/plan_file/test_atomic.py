"""Files appear completely or not at all."""

import pytest

from mamo_core.atomic import atomic_folder, atomic_path, check_writable
from mamo_core.errors import InputError


def test_the_file_appears_at_the_end(tmp_path):
    with atomic_path(tmp_path / "a.jsonl.gz") as work:
        assert work.name.endswith(".a.jsonl.gz")
        work.write_text("x")
        assert not (tmp_path / "a.jsonl.gz").exists()
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("a.jsonl.gz", "x")]


def write_half(path, error):
    with atomic_path(path) as work:
        work.write_text("half")
        raise error


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_nothing_is_left_of_a_failure(tmp_path, error):
    with pytest.raises(error):
        write_half(tmp_path / "a", error)
    assert list(tmp_path.iterdir()) == []


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "file").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "file")
    with atomic_path(tmp_path / "link") as work:
        work.write_text("new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_text() == "new"


def test_what_cannot_be_written(tmp_path):
    with pytest.raises(InputError, match=r"x/y: no such folder '.*x'$"):
        check_writable(tmp_path / "x" / "y")
    with pytest.raises(InputError, match=r"is a folder, expected a file$"):
        check_writable(tmp_path)
    with pytest.raises(InputError, match=r"^/dev/null: is a device or pipe, expected a file$"):
        check_writable("/dev/null")


@pytest.mark.parametrize("exists", [False, True])
def test_a_folder_appears_at_the_end(tmp_path, exists):
    target = tmp_path / "own"
    if exists:
        target.mkdir()
    with atomic_folder(target) as work:
        (work / "sub").mkdir()
        (work / "sub" / "a").write_text("x")
        assert not (target / "sub").exists()
    assert [path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*")] == [
        "own",
        "own/sub",
        "own/sub/a",
    ]


def write_half_a_folder(path):
    with atomic_folder(path) as work:
        (work / "a").write_text("half")
        raise RuntimeError


@pytest.mark.parametrize("exists", [False, True])
def test_nothing_is_left_of_a_folder_that_failed(tmp_path, exists):
    target = tmp_path / "own"
    if exists:
        target.mkdir()
    with pytest.raises(RuntimeError):
        write_half_a_folder(target)
    assert [path.name for path in tmp_path.rglob("*")] == (["own"] if exists else [])
