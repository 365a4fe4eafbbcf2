"""Who reaches the scheduler of a run on this machine: nobody without the certificate made for it."""

import pytest
from distributed import Client
from distributed.security import Security

from sweep.workers import dask_cluster, jobs
from sweep.workers.cluster_file import Local


@pytest.fixture(scope="module")
def address():
    with dask_cluster.local(1, "tests.sweep.toy") as workers:
        yield workers._client.scheduler.address


def strangers():
    """Return what another user of the machine may try with: nothing, or a certificate of their own."""
    return {"in the clear": ("tcp", None), "another certificate": ("tls", Security.temporary())}


@pytest.mark.parametrize("stranger", strangers())
def test_a_stranger_is_refused(address, stranger):
    protocol, security = strangers()[stranger]
    assert address.startswith("tls://127.0.0.1:")
    with pytest.raises((OSError, TimeoutError)):
        Client(address.replace("tls", protocol, 1), security=security, timeout=2)


def test_so_does_a_cluster_file_of_this_machine():
    with jobs._local(Local(kind="local", minimum_workers=1, maximum_workers=1), None) as cluster:
        assert cluster.scheduler_address.startswith("tls://127.0.0.1:")
