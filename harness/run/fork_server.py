"""A fork server: a process that has loaded modules and forks for each order, so that a child starts in milliseconds.

Being the parent of its children, it knows how each ended, and tells it. It has one thread, and ends once nobody can order
any more; its children end with it.

An order is one byte with two descriptors: the child's end of its pipe, and where the child's number and its exit code are told.
The child reads from its pipe what it is to do.
"""

import gc
import os
import pickle
import selectors
import signal
import socket
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from multiprocessing.connection import Connection
from typing import NoReturn

from plumbline.harness.intake.bounded import end_with_parent


def main(orders: int, modules: Sequence[str]) -> None:
    """Load these modules, then serve.

    Args: orders: the descriptor of a socket.

    A module that raises is left to the child that wants it. Garbage is not searched for while modules are loaded, since what
    they are made of stays; it is frozen then, or the first search of each child would write to all of that memory, and copy it.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is for whoever orders, here and in what is forked
    gc.disable()
    for name in modules:
        with suppress(Exception):
            import_module(name)
    gc.collect()
    gc.freeze()
    gc.enable()
    serve(socket.socket(fileno=orders))


def serve(orders: socket.socket) -> NoReturn:
    """Fork for each order, tell how each child ended, and end this process once nobody orders any more."""
    server, telling = os.getpid(), dict[int, Connection]()
    woken, wakes = socket.socketpair()
    for end in (woken, wakes):
        end.setblocking(False)
    usual = signal.signal(signal.SIGCHLD, _waking)
    signal.set_wakeup_fd(wakes.fileno(), warn_on_full_buffer=False)
    with selectors.DefaultSelector() as selector:
        for source in (orders, woken):
            selector.register(source, selectors.EVENT_READ)
        while True:
            ready = [key.fileobj for key, _ in selector.select()]
            if woken in ready:
                woken.recv(4096)
            _tell(telling)
            if orders not in ready:
                continue
            byte, descriptors, _, _ = socket.recv_fds(orders, 1, 2)
            if not byte:
                os._exit(0)
            pipe, tells = (Connection(each) for each in descriptors)
            child = os.fork()
            if child == 0:
                signal.signal(signal.SIGCHLD, usual)
                signal.set_wakeup_fd(-1)
                selector.close()
                for unused in (orders, woken, wakes):
                    unused.close()
                for other in (tells, *telling.values()):
                    other.close()
                _be_the_child(pipe, server)
            pipe.close()
            telling[child] = tells
            _send(tells, child)


def _waking(*_: object) -> None:
    """That it comes is enough."""


def _tell(telling: dict[int, Connection]) -> None:
    """Tell how those ended that have."""
    while telling:
        ended, status = os.waitpid(-1, os.WNOHANG)
        if not ended:
            return
        if ended in telling:
            with telling.pop(ended) as tells:
                _send(tells, os.waitstatus_to_exitcode(status))


def _send(tells: Connection, number: int) -> None:
    with suppress(OSError):  # nobody wants to know any more
        tells.send_bytes(b"%d" % number)


def _be_the_child(pipe: Connection, server: int) -> NoReturn:
    """Do what the pipe says, and end, as Python would; nobody waits for threads that were left."""
    code = 1
    try:
        end_with_parent()
        if os.getppid() != server:  # it died before its death could be felt here
            os._exit(1)
        try:
            message = pipe.recv_bytes()
        except EOFError:  # whoever ordered was killed meanwhile
            os._exit(1)
        folder, sys.path[:], order = pickle.loads(message)
        os.chdir(folder)
        function, arguments = pickle.loads(order)
        function(pipe, *arguments)
        code = 0
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
        if code and code is not stop.code:
            print(stop.code, file=sys.stderr)
    except BaseException:
        traceback.print_exc()
    finally:
        for stream in (sys.stdout, sys.stderr):
            with suppress(Exception):
                stream.flush()
        os._exit(code & 0xFF)
