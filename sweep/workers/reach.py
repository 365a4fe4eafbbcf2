"""Check before a run that a running scheduler can be used, with one-line errors."""

import os
import socket
import ssl
import tempfile
from collections.abc import Sequence
from pathlib import Path

import dask
from distributed import Client
from distributed.comm.addressing import parse_address, parse_host_port
from distributed.security import Security

import railvib
from railvib.errors import InputError
from sweep.storage import location

TIMEOUT_S = 10.0
"""Time to wait for an answer of the scheduler [s]."""
WORKERS_TIMEOUT_S = 60.0
"""Time to wait for its first worker [s]."""


def check(address: str, security: Security | None, directory: Path, store: str | None) -> None:
    """Check that scheduler and workers can be reached, are compatible, and see our files.

    Raises
    ------
    InputError
        If not, with the reason.
    """
    fault = _refusal(address, security)
    if fault is None:
        with (
            dask.config.set({"distributed.comm.timeouts.connect": f"{TIMEOUT_S}s"}),
            Client(address, security=security, set_as_default=False) as client,
        ):
            try:
                client.wait_for_workers(1, timeout=WORKERS_TIMEOUT_S)
            except TimeoutError:
                fault = f"no worker has joined it within {WORKERS_TIMEOUT_S:g} s"
            else:
                fault = _unfit(client, directory, store)
    if fault is not None:
        raise InputError(f"--scheduler = {address!r}: {fault}")


def _refusal(address: str, security: Security | None) -> str | None:
    """Connect as Dask does, and return what fails; Dask itself would only report a timeout."""
    try:
        protocol, place = parse_address(address, strict=True)
        host, port = parse_host_port(place)
    except ValueError:
        port = None
    if not port or protocol not in ("tcp", "tls"):
        return "must be tcp://HOST:PORT or tls://HOST:PORT"
    if (security is not None) != (protocol == "tls"):
        return (
            "certificates are for tls://HOST:PORT" if security else "tls://… asks for --tls-ca and --tls-cert"
        )
    try:
        with socket.create_connection((host, port), TIMEOUT_S) as plain:
            if security is None:
                reply = plain.recv(1)
            else:
                context = security.get_connection_args("client")["ssl_context"]
                with context.wrap_socket(plain, server_hostname=host) as encrypted:
                    reply = encrypted.recv(1)  # where a refusal of our certificate arrives
    except ssl.SSLCertVerificationError:
        return "its certificate is not signed by --tls-ca"
    except ssl.SSLError as error:
        alert = (error.reason or "").lower().replace("_", " ")
        if "alert" in alert:
            return f"it refuses our certificate ({alert})"
        return f"no connection by TLS ({alert}); does it listen at tcp://…?"
    except TimeoutError:
        return "does not answer" if security else "does not answer; does it listen at tls://…?"
    except OSError as error:
        return f"cannot be reached: {error.strerror or error}"
    return None if reply else "closes the connection" if security else "closes the connection; is it tls://…?"


def _unfit(client: Client, directory: Path, store: str | None) -> str | None:
    """Return why the workers are unfit: threads, another model, other files; None if they are fit."""
    threads = client.nthreads()
    many = [worker for worker, count in threads.items() if count != 1]
    if many:
        return f"worker {many[0]} has {threads[many[0]]} threads; must be started with --nthreads 1"
    folders = [directory.absolute(), *([Path(store)] if store and not location.is_bucket(store) else [])]
    existing = [next(parent for parent in (folder, *folder.parents) if parent.is_dir()) for folder in folders]
    probes = [tempfile.NamedTemporaryFile(prefix=".railvib-", dir=folder) for folder in existing]
    try:
        answers = client.run(_look, [probe.name for probe in probes], store, on_error="return")
    finally:
        for probe in probes:
            probe.close()
    for worker, answer in answers.items():
        if isinstance(answer, BaseException):
            return f"worker {worker}: {type(answer).__name__}: {answer}".partition("\n")[0]
        if answer != railvib.MODEL_VERSION:
            return f"worker {worker}: {answer}"
    return None


def _look(probes: Sequence[str], store: str | None) -> str:
    """Return a worker's model version, or what is wrong there."""
    for probe in probes:
        if not os.path.exists(probe):
            return f"does not see the folder {os.path.dirname(probe)}, where results go"
    if store:
        location.at(store).check()
    return railvib.MODEL_VERSION
