"""An S3 server on the loopback address, and the environment that leads to it."""

import logging
import urllib.request
from collections.abc import Iterator

import pytest
from moto.server import ThreadedMotoServer

from sweep.storage import location

BUCKET = "vibration"
SECRET = "not-to-be-told"


@pytest.fixture(scope="module")
def s3() -> Iterator[str]:
    """Return the address of an empty bucket; whoever asks finds server and credentials in the environment."""
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    endpoint = f"http://{host}:{port}"
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {
            "AWS_ENDPOINT_URL": endpoint,
            "AWS_ALLOW_HTTP": "true",
            "AWS_ACCESS_KEY_ID": "tester",
            "AWS_SECRET_ACCESS_KEY": SECRET,
            "AWS_REGION": "eu-north-1",
        }.items():
            patch.setenv(name, value)
        location.at.cache_clear()
        urllib.request.urlopen(
            urllib.request.Request(
                f"{endpoint}/{BUCKET}",
                data=b'<CreateBucketConfiguration xmlns="http://s3.amazonaws.com/doc/2006-03-01/">'
                b"<LocationConstraint>eu-north-1</LocationConstraint></CreateBucketConfiguration>",
                method="PUT",
            )
        ).close()
        yield f"s3://{BUCKET}"
        location.at.cache_clear()
    server.stop()
