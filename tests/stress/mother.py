"""A process that has loaded the command line and forks a run of it for each line of arguments that it is told.

A run starts in milliseconds that way, and so do its children, which are forked too: what is killed is the parent of a run, as a
person starts it, without the seconds in which it loads and in which it draws a report.
"""

import json
import os
import signal
import socket
import sys

import psutil

import plumbline.harness.cli.main
import plumbline.harness.findings.summary
import plumbline.harness.run.campaign
import plumbline.harness.run.isolated
import plumbline.harness.run.timed_processes
from plumbline.harness.run import fork_servers
from plumbline.harness.run.fork_server import serve
from plumbline.harness.study import plugins
from plumbline.harness.study.provenance import sources_of
from tests.stress.unreported import end_with_the_summary


def run(arguments: list[str], log: str) -> int:
    """The command line in this process; its exit code."""
    stream = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(stream, 1)
    os.dup2(stream, 2)
    try:
        plumbline.harness.cli.main.main(arguments)
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else 1
    return 0


def born(_origin: fork_servers.Origin, orders: socket.socket) -> psutil.Process:
    """A fork server that is forked itself: it lets go of what the run has open, its own other end among it."""
    server = os.fork()
    if server == 0:
        os.closerange(3, orders.fileno())
        os.closerange(orders.fileno() + 1, 4096)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        serve(orders)
    return psutil.Process(server)


if __name__ == "__main__":
    for case in plugins.cases():
        sources_of(case, "sound")
    end_with_the_summary()
    fork_servers._born = born
    for line in sys.stdin:
        told = json.loads(line)
        child = os.fork()
        if child == 0:
            os._exit(run(told["arguments"], told["log"]))
        print(child, flush=True)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
