"""Replays as a person sees them: pixels of the page, moved by its time bar."""

import io
import signal
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.colors import rgb_to_hsv
from matplotlib.image import imread
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

pytestmark = pytest.mark.browser

PATIENCE = 240.0
"""How long to wait for anything, s: a picture takes a second where there is no graphics card."""

BESIDE = slice(320, 950)
"""Columns of the window between what stands left and right of the scene."""

ENTER = """
const value = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value");
value.set.call(arguments[0], arguments[1]);
arguments[0].dispatchEvent(new Event("input", {bubbles: true}));
"""
"""At once, as typed digits are times, too, and each costs a replay up to there."""

VIEW = [sys.executable, "-c", "from mamo_core.cli.main import main; main()", "view"]


def wait(browser, condition):
    return WebDriverWait(browser, PATIENCE, poll_frequency=1.0).until(condition)


def bar(browser):
    """The handle of the time bar, once it is there."""
    return wait(browser, lambda b: b.find_elements(By.CSS_SELECTOR, "[role=slider]"))[-1]


def seek(browser, seconds):
    """Enter the time: the bar goes there and stays, once it has noticed that it is to stop."""
    handle = bar(browser)
    box = browser.find_element(By.CSS_SELECTOR, "input.mantine-NumberInput-input")

    def there(_):
        if abs(float(handle.get_attribute("aria-valuenow")) - seconds) < 1e-3:
            return True
        browser.execute_script(ENTER, box, f"{seconds:.2f}")
        return False

    WebDriverWait(browser, PATIENCE, poll_frequency=3.0).until(there)


def picture(browser):
    """The scene (h, w, 3), hue, saturation and value, 0 to 1, when it has stopped changing."""
    seen = [browser.get_screenshot_as_png()]

    def still(_):
        seen.append(browser.get_screenshot_as_png())
        return seen[-1] == seen[-2]

    wait(browser, still)
    return scene(seen[-1])


def scene(screenshot):
    """Hue, saturation and value of a screenshot (PNG), without what stands beside the scene."""
    return rgb_to_hsv(imread(io.BytesIO(screenshot))[:, BESIDE, :3])


def strong(image, degrees, tolerance=15.0):
    """Pixels of a hue that are no grey."""
    apart = np.abs((image[..., 0] * 360.0 - degrees + 180.0) % 360.0 - 180.0)
    return (apart < tolerance) & (image[..., 1] > 0.25) & (image[..., 2] > 0.3)


def middle(mask):
    return np.argwhere(mask).mean(axis=0)


def complaints(browser):
    return [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]


def test_the_time_bar_moves_robot_and_objects(browser, shown):
    recording = shown.recording
    pushes = [action.kind for action in recording.plan.actions].count("push")
    assert pushes >= 2
    ends = {s.motion: float(recording.times[s.last]) for s in recording.stretches}
    browser.get(shown.page.as_uri())
    seek(browser, 0.0)
    start = picture(browser)
    seen = []
    for motion in range(pushes):
        seek(browser, ends[motion])
        seen.append(picture(browser))
    seek(browser, float(recording.times[-1]))
    end = picture(browser)
    seek(browser, 0.0)
    again = picture(browser)

    blue, red, yellow = (strong(start, hue) for hue in (208, 6, 50))
    assert min(blue.sum(), red.sum()) > 2000
    assert yellow.sum() > 200
    grey = (start[..., 1] < 0.1) & (start[..., 2] > 0.4) & (start[..., 2] < 0.85)
    assert grey.sum() > 5000, "the robot"
    brown = (np.abs(start[..., 0] * 360.0 - 32.0) < 8.0) & (start[..., 1] > 0.2)
    assert brown.sum() > 5000, "the board"

    for before, after in zip([start, *seen], seen, strict=False):
        assert (strong(before, 208) ^ strong(after, 208)).sum() > 300, "a push moves what is blue"
    assert np.linalg.norm(middle(strong(end, 50)) - middle(yellow)) > 40, "the target is taken out"
    changed = np.abs(again - start).max(axis=2) > 0.1
    assert changed.mean() < 0.01, "back at the start"
    loaded = browser.execute_script(
        "return performance.getEntriesByType('resource').map(entry => entry.name)"
    )
    assert [name for name in loaded if not name.startswith(("blob:", "data:"))] == []
    assert complaints(browser) == []


def test_a_live_replay_plays(browser, shown):
    command = [*VIEW, str(shown.file), "--live", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as served:
        try:
            address = next(line for line in served.stdout if line.startswith("http")).split()[0]
            browser.get(address)
            handle = bar(browser)
            first = handle.get_attribute("aria-valuenow")
            wait(browser, lambda _: handle.get_attribute("aria-valuenow") != first)
            wait(browser, lambda b: strong(scene(b.get_screenshot_as_png()), 208).sum() > 2000)
            assert complaints(browser) == []
        finally:
            served.send_signal(signal.SIGINT)
    assert served.returncode == 130
