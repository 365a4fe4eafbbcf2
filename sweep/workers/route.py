"""The address at which a worker listens: the one from which its machine reaches the scheduler's.

``python -m sweep.workers.route HOST`` prints it; jobs call it where they run.
"""

import socket
import sys


def address_towards(host: str) -> str:
    """Return the address of this machine from which packets to a host go out.

    Raises
    ------
    OSError
        If the host has no address, or none that can be reached.
    """
    family, kind, protocol, _name, place = socket.getaddrinfo(host, 9, type=socket.SOCK_DGRAM)[0]
    with socket.socket(family, kind, protocol) as probe:
        probe.connect(place)  # sends nothing
        return str(probe.getsockname()[0])


if __name__ == "__main__":
    print(address_towards(sys.argv[1]))
