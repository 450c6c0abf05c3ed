"""A headless Chromium that finds nothing but this machine, and a plan to be shown in it."""

import shutil
import subprocess
import sys
from types import SimpleNamespace

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

from mamo_core.recording import read_recording

MAMO = [sys.executable, "-c", "from mamo_core.cli.main import main; main()"]
SEED = 4
"""Of a shelf whose plan has two pushes and a pick and place."""

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1280,800",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
)


@pytest.fixture(scope="session")
def shown(tmp_path_factory):
    """``page`` (HTML) and ``file`` (recording) of a plan, made as a user makes them."""
    folder = tmp_path_factory.mktemp("shown")

    def mamo(*arguments):
        done = subprocess.run(
            [*MAMO, *arguments], cwd=folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr

    shelf = ("shelf", "--level", "hard", "--movables", "8", "--seed", str(SEED))
    mamo("problem", "generate", *shelf, "-o", "problem.json")
    mamo("plan", "problem.json", "-o", "plan.json")
    mamo("view", "plan.json", "--html", "replay.html", "-o", "kept.npz")
    file = folder / "kept.npz"
    return SimpleNamespace(page=folder / "replay.html", file=file, recording=read_recording(file))


@pytest.fixture
def browser(tmp_path):
    """A driver of a fresh browser."""
    programs = [shutil.which(name) for name in ("chromium", "chromedriver")]
    if None in programs:
        pytest.fail("needs Chromium: apt-get install chromium chromium-driver", pytrace=False)
    options = webdriver.ChromeOptions()
    options.binary_location = programs[0]
    for flag in (*FLAGS, f"--user-data-dir={tmp_path / 'profile'}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(programs[1]))
    try:
        driver.set_page_load_timeout(300)
        yield driver
    finally:
        driver.quit()
