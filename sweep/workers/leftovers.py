"""Files of a run that nobody needs once it has ended, but which stay when it is killed."""

from pathlib import Path

FOLDER = "cluster"
"""Folder of a results directory with what jobs print, and while they run their certificate."""
CERTIFICATE, KEY = "certificate.pem", "key.pem"


def discard_keys(directory: Path) -> None:
    """Remove the certificate and the key of a run that has ended."""
    for name in (CERTIFICATE, KEY):
        (directory / FOLDER / name).unlink(missing_ok=True)
