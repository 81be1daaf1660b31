"""What a child says is read line by line, whatever it says and however it comes."""

import multiprocessing
import os
from collections.abc import Iterator
from multiprocessing.connection import Connection

import numpy as np
import pytest

from plumbline.harness.intake.safe_text import readable
from plumbline.harness.run.message import LONGEST, BrokenMessage, Inbox, read_value, send
from plumbline.harness.store.record import Sample

SAMPLE = Sample(process=0, block=1, steps=7, cpu=0.1, wall=0.2, canary=0.3, switches=0)


@pytest.fixture
def ends() -> Iterator[tuple[Inbox, Connection]]:
    ours, theirs = multiprocessing.Pipe()
    yield Inbox(ours), theirs
    ours.close()
    theirs.close()


def test_messages_come_in_their_order_one_at_a_time(ends: tuple[Inbox, Connection]) -> None:
    inbox, pipe = ends
    for steps in (5, 6, 7):
        send(pipe, "steps", steps)
    assert [inbox.next(1.0) for _ in range(3)] == [("steps", 5), ("steps", 6), ("steps", 7)]
    assert inbox.next(0.01) is None


def test_a_line_may_come_in_pieces(ends: tuple[Inbox, Connection]) -> None:
    inbox, pipe = ends
    for piece in (b'{"st', b'eps": 5', b"}"):
        os.write(pipe.fileno(), piece)
        assert inbox.lines() == []
    os.write(pipe.fileno(), b"\n")
    assert inbox.lines() == [("steps", 5)]


def test_what_was_said_before_a_death_is_heard_and_then_the_end(ends: tuple[Inbox, Connection]) -> None:
    inbox, pipe = ends
    send(pipe, "sample", SAMPLE)
    pipe.close()
    told = inbox.next(1.0)
    assert told is not None
    assert read_value(Sample, told[1]) == SAMPLE
    with pytest.raises(EOFError):
        inbox.next(1.0)


def test_numbers_that_are_not_finite_come_whole(ends: tuple[Inbox, Connection]) -> None:
    inbox, pipe = ends
    send(pipe, "values", [float("nan"), float("inf"), 5e-324])
    told = inbox.next(1.0)
    assert told is not None
    assert str(told[1]) == "[nan, inf, 5e-324]"


@pytest.mark.parametrize("value", [np.int64(5), np.zeros(2), b"bytes", {1: 2}, {1, 2}, object()])
def test_what_json_has_no_form_for_is_refused_by_name_before_it_is_sent(ends: tuple[Inbox, Connection], value: object) -> None:
    with pytest.raises(TypeError, match=r"record\.resolved\.one"):
        send(ends[1], "record", {"resolved": {"one": value}})


def test_no_message_is_too_long(ends: tuple[Inbox, Connection]) -> None:
    with pytest.raises(ValueError, match="expected at most"):
        send(ends[1], "text", "x" * LONGEST)


@pytest.mark.parametrize("cpu", ["0.1", True, None, [0.1]])
def test_a_sample_of_other_types_is_broken(cpu: object) -> None:
    with pytest.raises(BrokenMessage, match="cpu"):
        read_value(Sample, {"process": 0, "block": 1, "steps": 7, "cpu": cpu, "wall": 0.2, "canary": 0.3, "switches": 0})


def test_text_is_made_readable() -> None:
    assert readable("a\x1b[31m\x00 \ud800 \u202e end\n") == "a\\u001b[31m\\u0000 \\ud800 \\u202e end\n"
    assert readable("x" * 20, 10) == "xxxxxxx..."
