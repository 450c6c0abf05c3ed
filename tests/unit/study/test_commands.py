"""``mamo study`` as a user calls it: one real problem, and what is wrong on the command line."""

import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
REAL = f"""\
schema_version: 1
name: real
problems: [{ROOT}/problems/shelf_5_easy_seed1.yaml]
recipes: [{{recipe: m4m, name: once, set: {{search.iterate: false, search.nearby: {{}}}}}}]
budget: 60
"""


@pytest.fixture(autouse=True)
def _interrupts_as_before():
    handler = signal.getsignal(signal.SIGINT)
    yield
    signal.signal(signal.SIGINT, handler)


def mamo(*arguments, cwd):
    code = "from mamo_core.cli.main import main; main()"
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_real_study(tmp_path):
    (tmp_path / "real.yaml").write_text(REAL)
    done = mamo("study", "run", "real.yaml", "--workers", "1", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    status = json.loads(done.stdout)
    assert (status["total"], status["done"], status["verified"]) == (1, 1, 1)
    store = tmp_path / "out" / "real.db"
    assert status["store"] == "out/real.db"
    report = json.loads(mamo("study", "report", store, "--json", cwd=tmp_path).stdout)
    unknown = mamo("study", "report", store, "--against", "no_such", cwd=tmp_path)
    assert unknown.returncode == 2
    assert "--against: no recipe 'no_such'" in unknown.stderr
    assert [(g["planner"], g["class"], g["success"]) for g in report["groups"]] == [
        ("once", "all", 1.0),
        ("once", "easy", 1.0),
    ]
    assert {"loading", "composing", "rollouts"} <= set(report["shares"][0]["parts"])
    assert mamo("study", "export", store, "--plans", "plans", cwd=tmp_path).returncode == 0
    (plan,) = (tmp_path / "plans").iterdir()
    verified = mamo("verify", plan, cwd=tmp_path)
    assert verified.returncode == 0, verified.stdout
    again = mamo("study", "run", "real.yaml", "--workers", "1", cwd=tmp_path)
    assert "1 of 1 tasks are done already" in again.stderr
    assert "[1/1]" not in again.stderr


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("run",), 2, "Missing argument"),
        (("run", "none.yaml"), 2, "none.yaml: no such file"),
        (("run", "real.yaml", "--executor", "slurm"), 2, "slurm"),
        (("run", "real.yaml", "--workers", "0"), 2, "--workers"),
        (("run", "real.yaml", "--set", "budgt=3"), 2, "--set budgt: unknown key 'budgt'"),
        (("run", "real.yaml", "--set", "engines=[toaster]"), 2, "unknown backend 'toaster'"),
        (("run", "real.yaml", "--set", "problems=[no.yaml]"), 2, "no.yaml: No such file"),
        (("run", "real.yaml", "--store", "no/s.db"), 2, "no/s.db: expected a file in a folder"),
        (("status", "none.db"), 2, "none.db: no such store of a study"),
        (("report", "real.yaml"), 2, "real.yaml: is not the store of a study"),
        (
            ("report", "none.db", "-o", "r.pdf"),
            2,
            "r.pdf: ending '.pdf' (valid: .md, .html, .json)",
        ),
        (("export", "none.db"), 2, "nothing to export: expected -o FILE or --plans FOLDER"),
        (("export", "none.db", "-o", "r.xls"), 2, "r.xls: ending '.xls' (valid: .csv, .parquet,"),
    ],
)
def test_bad_input(tmp_path, monkeypatch, capsys, arguments, code, message):
    from mamo_core.cli.main import main

    (tmp_path / "real.yaml").write_text(REAL)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as caught:
        main(["study", *arguments])
    out, err = capsys.readouterr()
    assert (caught.value.code, out) == (code, "")
    assert message in err
    assert "Traceback" not in err


def test_no_room_for_the_default_store(tmp_path, monkeypatch, capsys):
    from mamo_core.cli.main import main

    (tmp_path / "real.yaml").write_text(REAL)
    (tmp_path / "out").touch()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as caught:
        main(["study", "run", "real.yaml"])
    assert caught.value.code == 2
    assert "error: out: cannot be made: File exists; choose a --store" in capsys.readouterr().err


def test_a_report_of_nothing(tmp_path, monkeypatch, capsys):
    from mamo_core.cli.main import main
    from mamo_core.study.store import create_store

    with create_store(tmp_path / "s.db"):
        pass
    with pytest.raises(SystemExit) as caught:
        main(["study", "report", str(tmp_path / "s.db")])
    assert caught.value.code == 2
    assert "no task is finished yet" in capsys.readouterr().err


def test_seconds_without_a_split_are_refused(tmp_path, capsys):
    from mamo_core.cli.main import main

    with pytest.raises(SystemExit) as caught:
        main(["study", "report", str(tmp_path / "s.db"), "--seconds", "3"])
    assert caught.value.code == 2
    assert "--seconds 3: is for --split-by" in capsys.readouterr().err


@pytest.mark.parametrize("path", sorted((ROOT / "studies").glob("*.yaml")), ids=lambda p: p.name)
def test_shipped_studies_can_be_read(path):
    from mamo_core.study.definition import load_study

    study = load_study(path)
    assert study.name == path.stem
    assert study.variants


def test_the_example_in_the_docs_can_be_read(tmp_path):
    from mamo_core.study.definition import load_study

    text = (ROOT / "docs" / "studies.md").read_text()
    (block,) = re.findall(r"^```yaml study\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    (tmp_path / "example.yaml").write_text(block)
    assert len(load_study(tmp_path / "example.yaml").variants) == 4


def test_the_schema(capsys):
    from mamo_core.cli.main import main

    with pytest.raises(SystemExit):
        main(["schema", "study"])
    schema = json.loads(capsys.readouterr().out)
    assert set(schema["required"]) == {"schema_version", "name", "problems", "recipes"}
