"""A real headless Chromium that opens the report, installed when it is missing."""

import importlib
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

PLAYWRIGHT = "playwright==1.65.2"
FLAGS = (
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


def chromium() -> str:
    """Return the path of Chromium, after installing the system's package if it is not there."""
    path = shutil.which("chromium")
    if path is None:
        subprocess.run(["apt-get", "update", "-qq"], check=True, capture_output=True)
        subprocess.run(["apt-get", "install", "-y", "-qq", "chromium"], check=True, capture_output=True)
        path = shutil.which("chromium")
    assert path is not None
    return path


@contextmanager
def start_browser(folder: Path) -> Iterator[Any]:
    """Yield a browser, driven by a library that is installed into a folder for the occasion."""
    executable = chromium()
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        + ["--target", str(folder), PLAYWRIGHT],
        check=True,
        capture_output=True,
    )
    sys.path.append(str(folder))
    try:
        importlib.invalidate_caches()
        api = importlib.import_module("playwright.sync_api")
        with api.sync_playwright() as driver:
            browser = driver.chromium.launch(
                executable_path=executable, headless=True, chromium_sandbox=False, args=list(FLAGS)
            )
            yield browser
            browser.close()
    finally:
        sys.path.remove(str(folder))
