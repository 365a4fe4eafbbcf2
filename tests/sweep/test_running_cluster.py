"""A scheduler and workers that are there already, joined through `--scheduler`, in the clear and over TLS."""

import contextlib
import json
import os
import signal
import socket
import ssl
import subprocess
import sys
import time

import psutil
import pytest
import trustme

from sweep.storage import records
from tests.sweep.small import STUDY, invoke

DASK = [sys.executable, "-m", "dask"]


@contextlib.contextmanager
def started(folder, *tls, workers=2, threads=1):
    """Start `dask scheduler` and some `dask worker` as processes; return the scheduler's address."""
    told = folder / "scheduler.json"
    protocol = ["--protocol", "tls"] if tls else []
    commands = [
        [*DASK, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", *protocol, *tls],
        *[
            [*DASK, "worker", "--nthreads", str(threads), "--no-dashboard", "--host", "127.0.0.1", *tls]
            for _ in range(workers)
        ],
    ]
    with contextlib.ExitStack() as stack:
        for number, command in enumerate(commands):
            log = stack.enter_context((folder / f"{number}.log").open("w"))
            process = subprocess.Popen(
                [*command, "--scheduler-file", str(told)], cwd=folder, stdout=log, stderr=log
            )
            stack.callback(process.wait)
            stack.callback(process.terminate)
            deadline = time.monotonic() + 60.0
            while not told.exists() and time.monotonic() < deadline:
                time.sleep(0.05)
        yield json.loads(told.read_text())["address"]


def assert_complete(out, workers):
    assert "1 of 1 complete" in invoke("status", out).output
    made = {record["worker"] for record in records.commits(out, "spectra")}
    assert 1 <= len(made) <= workers
    assert f"{socket.gethostname()}:{os.getpid()}" not in made


def test_a_run_on_a_cluster_that_is_there(study_folder):
    with started(study_folder) as address:
        result = invoke("run", "small.toml", "--scheduler", address)
        assert result.exit_code == 0, result.output
        assert_complete(study_folder / "runs" / "small", 2)
        for given, message in [
            (address.replace("tcp", "tls"), "tls://… asks for --tls-ca and --tls-cert"),
            ("127.0.0.1", "must be tcp://HOST:PORT or tls://HOST:PORT"),
            ("tcp://127.0.0.1:9", "cannot be reached: Connection refused"),
        ]:
            refused(study_folder, message, "--scheduler", given)


@pytest.fixture(scope="module")
def certificates(tmp_path_factory):
    """Return paths of an authority's certificate, and of certificates by it and by another one."""
    folder = tmp_path_factory.mktemp("certificates")
    paths = {}
    for name in ("ours", "theirs"):
        authority = trustme.CA()
        authority.cert_pem.write_to_path(folder / f"{name}.ca.pem")
        issued = authority.issue_cert("127.0.0.1", "localhost")
        issued.private_key_and_cert_chain_pem.write_to_path(folder / f"{name}.pem")
        paths[name] = folder / f"{name}.pem"
        paths[f"{name} ca"] = folder / f"{name}.ca.pem"
    return paths


def refused(study_folder, message, *options):
    result = invoke("run", "small.toml", "--out", "refused", *options)
    assert result.exit_code == 2, result.output
    assert message in result.output
    assert result.output.count("\n") == 1
    assert not (study_folder / "refused").exists()


def say_nothing_of_ourselves(address, ca):
    """Connect without a certificate, and wait for what the scheduler itself says to that."""
    host, port = address.removeprefix("tls://").split(":")
    trusting = ssl.create_default_context(cafile=ca)
    with (
        socket.create_connection((host, int(port)), 10.0) as plain,
        trusting.wrap_socket(plain, server_hostname=host) as encrypted,
    ):
        encrypted.recv(1)


def test_a_run_over_tls_and_clients_that_are_refused(study_folder, computed, certificates):
    ours, ca = certificates["ours"], certificates["ours ca"]
    files = ["--tls-ca-file", str(ca), "--tls-cert", str(ours), "--tls-key", str(ours)]
    with started(study_folder, *files) as address:
        assert address.startswith("tls://")
        at = ("--scheduler", address)
        refused(study_folder, "asks for --tls-ca and --tls-cert", *at)
        refused(study_folder, "asks for --tls-ca and --tls-cert", *at, "--tls-ca", ca)
        with pytest.raises(ssl.SSLError, match="certificate required"):
            say_nothing_of_ourselves(address, ca)
        trusted = (*at, "--tls-ca", ca, "--tls-cert")
        refused(study_folder, "it refuses our certificate", *trusted, certificates["theirs"])
        refused(study_folder, "--tls-cert = 'none.pem': cannot be read", *trusted, "none.pem")
        other = (*at, "--tls-ca", certificates["theirs ca"], "--tls-cert", ours)
        refused(study_folder, "its certificate is not signed by --tls-ca", *other)
        refused(study_folder, "does it listen at tls://…?", "--scheduler", address.replace("tls", "tcp"))
        # Another unevenness: only the spectra are left to compute.
        (study_folder / "small.toml").write_text(STUDY.replace("german-low", "german-high"), encoding="utf-8")
        result = invoke("run", "small.toml", *trusted, ours, "--store", computed / "out")
        assert result.exit_code == 0, result.output
        assert_complete(study_folder / "runs" / "small", 2)


def test_workers_that_cannot_compute_for_us_are_refused(study_folder):
    with started(study_folder, workers=1, threads=2) as address:
        refused(study_folder, "has 2 threads; must be started with --nthreads 1", "--scheduler", address)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ("--workers", 1, "--scheduler", "tcp://127.0.0.1:1"),
            "--workers and --scheduler: exclude each other",
        ),
        (("--tls-ca", "x"), "--tls-ca: is for --scheduler tls://HOST:PORT"),
        (("--dashboard", "--scheduler", "tcp://127.0.0.1:1"), "--dashboard: a scheduler that is running"),
    ],
)
def test_options_that_exclude_each_other(study_folder, options, message):
    refused(study_folder, message, *options)


def slow_run(study_folder, address, *options):
    """Start a run of many tasks in a process of its own, and return it when its first task has settled."""
    study = STUDY.replace("[30]", "{ start = 20, stop = 200, number = 400 }")
    (study_folder / "small.toml").write_text(study, encoding="utf-8")
    command = [sys.executable, "-m", "railvib", "run", "small.toml", "--scheduler", address, *options]
    process = subprocess.Popen(command, cwd=study_folder, stderr=subprocess.PIPE, text=True)
    log = study_folder / "runs" / "small" / "log.jsonl"
    deadline = time.monotonic() + 120.0
    while time.monotonic() < deadline and process.poll() is None:
        if log.exists() and '"done"' in log.read_text():
            return process
        time.sleep(0.05)
    raise AssertionError(process.communicate()[1])


def ended(process):
    """Return what a run that has to end by itself says last."""
    _, error = process.communicate(timeout=120.0)
    assert process.returncode == 1, error
    assert "Traceback" not in error, error[-6000:]
    return error.splitlines()[-1]


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_scheduler_that_is_lost_ends_the_run_in_one_line(study_folder, number):
    with started(study_folder) as address:
        process = slow_run(study_folder, address)
        os.kill(scheduler_process(address), number)
        assert ended(process) == (
            "the scheduler does not answer any more; what is done is kept; "
            "continue with: railvib resume runs/small"
        )


@pytest.mark.slow
def test_a_run_whose_workers_are_all_gone_ends(study_folder):
    with started(study_folder) as address:
        process = slow_run(study_folder, address, "--wait", "0.1")
        for worker in psutil.process_iter():
            with contextlib.suppress(psutil.Error):
                if worker.cwd() == str(study_folder) and "worker" in worker.cmdline():
                    worker.kill()
        last = ended(process)
        assert last.startswith(f"workers at {address}: none for ")
        assert last.endswith("continue with: railvib resume runs/small")


def scheduler_process(address):
    """Return the number of the process that listens there."""
    port = int(address.rpartition(":")[2])
    return next(
        connection.pid
        for connection in psutil.net_connections("tcp")
        if connection.status == "LISTEN" and connection.laddr.port == port
    )
