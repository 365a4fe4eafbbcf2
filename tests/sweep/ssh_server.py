"""A server that runs the commands of whoever has the right key, as `sshd` does; a process of its own."""

import asyncio
import os
import signal
import sys
from pathlib import Path

import asyncssh


async def execute(process: asyncssh.SSHServerProcess) -> None:
    """Run one command in a shell, and end it with its session."""
    with (Path(sys.argv[1]) / "commands").open("a") as log:
        log.write(f"{process.command}\n")
    child = await asyncio.create_subprocess_shell(
        process.command or "",
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        start_new_session=True,
    )
    await process.redirect(stdout=child.stdout, stderr=child.stderr)
    ended = asyncio.create_task(child.wait())
    gone = asyncio.create_task(process.wait_closed())
    await asyncio.wait([ended, gone], return_when=asyncio.FIRST_COMPLETED)
    if ended.done():
        process.exit(ended.result())
    else:
        os.killpg(child.pid, signal.SIGKILL)


async def serve(folder: Path) -> None:
    """Make keys, listen on the loopback address, and leave the port in a file."""
    host, key = (asyncssh.generate_private_key("ssh-ed25519") for _ in range(2))
    key.write_private_key(folder / "key")
    key.write_public_key(folder / "authorized")
    server = await asyncssh.listen(
        "127.0.0.1",
        0,
        server_host_keys=[host],
        authorized_client_keys=str(folder / "authorized"),
        process_factory=execute,
        encoding=None,
    )
    port = server.get_port()
    (folder / "known_hosts").write_text(f"[127.0.0.1]:{port} {host.export_public_key().decode()}")
    (folder / "port.partial").write_text(str(port))
    (folder / "port.partial").rename(folder / "port")
    await server.wait_closed()


if __name__ == "__main__":
    asyncio.run(serve(Path(sys.argv[1])))
