"""Certificates for connections between driver, scheduler and workers: a user's, or made for one run."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from distributed.security import Security

from railvib.errors import InputError
from sweep.workers.leftovers import CERTIFICATE, KEY

ROLES = ("scheduler", "worker", "client")


@dataclass(frozen=True)
class Certificates:
    """Certificate files in PEM form.

    Attributes
    ----------
    ca
        Certificates of trusted authorities.
    cert
        Our certificate.
    key
        Its private key, if it is not in the same file.
    """

    ca: str | None = None
    cert: str | None = None
    key: str | None = None

    def check(self) -> None:
        """Check that all files that a connection needs exist.

        Raises
        ------
        InputError
            If not.
        """
        for option, path in (("--tls-ca", self.ca), ("--tls-cert", self.cert), ("--tls-key", self.key)):
            if path is None and option != "--tls-key":
                raise InputError(
                    f"{option}: is missing; a scheduler at tls://… asks for --tls-ca and --tls-cert"
                )
            if path is not None and not os.access(path, os.R_OK):
                raise InputError(f"{option} = {path!r}: cannot be read")

    def security(self) -> Security:
        """Return Dask's security settings, which refuse unencrypted connections."""
        return Security(
            require_encryption=True,
            tls_ca_file=self.ca,
            tls_client_cert=self.cert,
            tls_client_key=self.key or self.cert,
        )


def security_of(folder: Path) -> Security:
    """Return what Dask asks for, for every role, with the certificate made for a run."""
    cert, key = str((folder / CERTIFICATE).resolve()), str((folder / KEY).resolve())
    files = {f"tls_{role}_cert": cert for role in ROLES} | {f"tls_{role}_key": key for role in ROLES}
    return Security(require_encryption=True, tls_ca_file=cert, **files)


@contextmanager
def temporary(folder: Path) -> Iterator[Security]:
    """Make a certificate for one run; its files, for nobody else to read, are removed at the end."""
    certificates = Security.temporary()
    cert, key = folder / CERTIFICATE, folder / KEY
    folder.mkdir(parents=True, exist_ok=True)
    try:
        for path, content in ((cert, certificates.tls_ca_file), (key, certificates.tls_client_key)):
            path.unlink(missing_ok=True)
            with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
                file.write(content)
        yield security_of(folder)
    finally:
        cert.unlink(missing_ok=True)
        key.unlink(missing_ok=True)
