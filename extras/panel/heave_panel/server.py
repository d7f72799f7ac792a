"""Serves the page until Ctrl-C."""

from __future__ import annotations

import secrets
import socket
import sys

import uvicorn
from fastapi import FastAPI
from heave_bringup.errors import CommandError
from heave_bringup.operate.link import RunLink
from nicegui import Client, ui

from heave_panel.command_post import CommandPost
from heave_panel.guard import PARAMETER, Guard, is_loopback
from heave_panel.page import Page
from heave_panel.run_worker import RunWorker

LEAVING_TIME = 20
"""Wall time after which a browser that does not answer is taken for gone, and leaves the command [s]."""

LARGEST_WAITING = 16
"""Pages that were fetched and that no browser has connected to yet; each keeps 0.5 MB. A browser takes a second."""


def serve(link: RunLink, listener: socket.socket, host: str) -> None:
    """Serve the page of the run of a `link` until Ctrl-C.

    Parameters
    ----------
    link : to the run
    listener : as from `listen`
    host : that it listens on; beyond this machine a browser needs the token that is printed
    """
    port = listener.getsockname()[1]
    token = "" if is_loopback(host) else secrets.token_urlsafe(24)
    worker, post = RunWorker(link), CommandPost()
    application = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    waiting: dict[str, Client] = {}

    @ui.page("/")
    def page(client: Client) -> None:
        leave_oldest(waiting)
        waiting[client.id] = client
        client.on_connect(lambda: waiting.pop(client.id, None))
        client.on_delete(lambda: waiting.pop(client.id, None))
        shown = Page(worker, post, link.place)
        client.on_connect(lambda: shown.arrive(client.tab_id or ""))
        client.on_delete(shown.leave)

    ui.run_with(application, title="heave panel", reconnect_timeout=LEAVING_TIME, favicon="⚓")
    config = uvicorn.Config(
        Guard(application, token),  # type: ignore[arg-type]
        log_level="warning",
        timeout_graceful_shutdown=1,
        server_header=False,
    )
    sys.stdout.write(f"panel     http://{_shown(host)}:{port}/{f'?{PARAMETER}={token}' if token else ''}\n")
    sys.stdout.write("Ctrl-C ends the panel; the run goes on\n")
    sys.stdout.flush()
    worker.start()
    try:
        uvicorn.Server(config).run(sockets=[listener])
    except KeyboardInterrupt:
        pass  # the way to end it
    finally:
        worker.close()


def leave_oldest(waiting: dict[str, Client]) -> None:
    """Delete the oldest of the pages `waiting` for their browser's connection where one more would be too many."""
    while len(waiting) >= LARGEST_WAITING:
        waiting.pop(next(iter(waiting))).delete()


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens on `port` of `host`, an address of this machine.

    Raises CommandError where the port is taken or the address is not one of this machine.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((host, port))
        listener.listen()
    except OSError as error:
        listener.close()
        raise CommandError(
            f"{host}:{port}: cannot be served: {error.strerror or error}; see --host and --port"
        ) from None
    return listener


def _shown(host: str) -> str:
    if host in ("0.0.0.0", "::"):
        return socket.gethostname()
    return f"[{host}]" if ":" in host else host
