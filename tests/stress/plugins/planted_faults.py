"""The table of planted faults: where each sits, what it does there, and what has to come of it."""

import os
import resource
import signal
import warnings
from dataclasses import replace

import numpy as np
from planted_deeds import (
    HUGE,
    INF,
    NAN,
    Endless,
    Fault,
    Mute,
    child,
    daemon,
    deaf,
    deep,
    die,
    doing,
    filled,
    held,
    hungry_child,
    linger,
    loop,
    malloc,
    marred,
    raising,
    state,
    told,
    twin,
    worded,
)

from plumbline.harness.adapter import Diverged, SettingsError, Unavailable, Unsupported

FAULTS: tuple[Fault, ...] = (
    *(
        Fault("state", f"{name}_{word}", "state", state(name, value), "diverged", f"{name} of body 'ball'")
        for name in ("p_WB", "q_WB", "v_WB", "w_WB")
        for word, value in (("nan", NAN), ("inf", INF), ("minus_inf", -INF), ("huge", HUGE))
    ),
    *(
        Fault("state", f"{name}_nan_{when}", "state", state(name, NAN, first=first), "diverged", f"{name} of body 'ball'")
        for name in ("p_WB", "q_WB", "v_WB", "w_WB")
        for when, first in (("at_the_start", 0), ("at_the_end", 50))
    ),
    Fault("state", "nan_of_the_last_body", "state", state("p_WB", NAN, row=1), "diverged", "p_WB of body 'other'"),
    Fault(
        "state", "nan_at_one_sample_alone", "state", state("v_WB", NAN, first=30, last=30), "diverged", "v_WB of body 'ball'"
    ),
    Fault("state", "norm_2", "state", state("q_WB", (2.0, 0.0, 0.0, 0.0)), "crashed", "q_WB of body 'ball'"),
    Fault("state", "norm_0", "state", state("q_WB", 0.0), "crashed", "got norm 0, expected 1"),
    Fault(
        "state",
        "norm_off_by_ten_millionths",
        "state",
        state("q_WB", (1.00001, 0.0, 0.0, 0.0)),
        "crashed",
        "q_WB of body 'ball'",
    ),
    Fault(
        "state",
        "too_many_bodies",
        "state",
        lambda out, _: out.p_WB.__setitem__(slice(None), np.zeros((3, 3))),
        "crashed",
        "ValueError",
    ),
    Fault(
        "state",
        "too_few_columns",
        "state",
        lambda out, _: out.p_WB.__setitem__(slice(None), np.zeros((2, 2))),
        "crashed",
        "ValueError",
    ),
    Fault("state", "text", "state", lambda out, _: out.p_WB.__setitem__(0, "far"), "crashed", "ValueError"),
    Fault("state", "complex_numbers", "state", lambda out, _: out.p_WB.__setitem__(0, 1j), "crashed", "TypeError"),
    Fault("state", "objects", "state", lambda out, _: out.p_WB.__setitem__(0, object()), "crashed", "TypeError"),
    *(
        Fault("state", f"{name}_never_written", "unwritten", name, "diverged", f"{name} of body 'ball'")
        for name in ("p_WB", "q_WB", "v_WB", "w_WB")
    ),
    *(
        Fault("contacts", f"{name}_{word}", "contacts", marred(name, value), "diverged", f"contacts().{name}: got")
        for name in ("point_W", "normal_W", "gap", "force_W")
        for word, value in (("nan", NAN), ("inf", INF), ("huge", HUGE))
    ),
    *(
        Fault("contacts", f"{name}_of_one_more", "contacts", told(name, np.zeros((2, 3))), "crashed", f"contacts().{name}: got")
        for name in ("point_W", "normal_W", "force_W")
    ),
    *(
        Fault("contacts", f"{name}_in_a_list", "contacts", told(name, [0.0]), "crashed", f"contacts().{name}: got list")
        for name in ("body_A", "body_B", "point_W", "gap")
    ),
    Fault(
        "contacts",
        "force_of_integers",
        "contacts",
        told("force_W", np.zeros((1, 3), dtype=int)),
        "crashed",
        "force_W: got int64",
    ),
    Fault("contacts", "body_of_floats", "contacts", told("body_A", np.zeros(1)), "crashed", "contacts().body_A: got float64"),
    Fault("contacts", "a_body_that_is_none", "contacts", told("body_B", np.array([7])), "crashed", "got body 7, expected 0..1"),
    Fault("contacts", "a_body_below_zero", "contacts", told("body_A", np.array([-1])), "crashed", "got body -1, expected 0..1"),
    Fault("contacts", "a_body_with_itself", "contacts", told("body_B", np.zeros(1, dtype=int)), "crashed", "expected A < B"),
    Fault(
        "contacts",
        "a_pair_the_wrong_way",
        "contacts",
        lambda c: replace(c, body_A=c.body_B, body_B=c.body_A),
        "crashed",
        "A < B",
    ),
    Fault("contacts", "a_normal_of_length_0", "contacts", told("normal_W", np.zeros((1, 3))), "crashed", "length is not 1"),
    Fault("contacts", "a_normal_of_length_2", "contacts", told("normal_W", np.full((1, 3), 2.0)), "crashed", "length is not 1"),
    Fault("contacts", "none", "contacts", lambda _: None, "crashed", "contacts(): got NoneType, expected Contacts"),
    Fault("contacts", "a_tuple", "contacts", lambda _: (), "crashed", "contacts(): got tuple, expected Contacts"),
    Fault("rays", "distance_nan", "cast", marred("distance", NAN), "diverged", "cast().distance: got nan"),
    Fault("rays", "distance_minus_inf", "cast", marred("distance", -INF), "diverged", "cast().distance: got -inf"),
    Fault("rays", "distance_huge", "cast", marred("distance", HUGE), "diverged", "cast().distance: got 1e+200"),
    Fault("rays", "distance_below_zero", "cast", marred("distance", -1.0), "crashed", "cast().distance: got -1.0"),
    Fault("rays", "normal_nan", "cast", marred("normal_W", NAN), "diverged", "cast().normal_W: got nan"),
    Fault("rays", "a_body_that_is_none", "cast", told("body", np.full(4, 99)), "crashed", "got body 99, expected -1..1"),
    Fault("rays", "a_body_below_minus_one", "cast", told("body", np.full(4, -2)), "crashed", "got body -2, expected -1..1"),
    Fault("rays", "too_few_hits", "cast", told("distance", np.zeros(3)), "crashed", "cast().distance: got float64 (3,)"),
    Fault("rays", "too_many_bodies", "cast", told("body", np.zeros(5, dtype=int)), "crashed", "cast().body: got int64 (5,)"),
    Fault(
        "rays",
        "normals_in_two_dimensions",
        "cast",
        told("normal_W", np.zeros((4, 2))),
        "crashed",
        "normal_W: got float64 (4, 2)",
    ),
    Fault("rays", "hits_of_text", "cast", told("distance", np.array(["far"] * 4)), "crashed", "cast().distance: got <U3 (4,)"),
    Fault("rays", "none", "cast", lambda *_: None, "crashed", "cast(): got NoneType, expected Hits"),
    Fault("rays", "directions_changed", "cast_mutating", None, "crashed", "got directions that were changed"),
    Fault("images", "depth_nan", "render", marred("depth", NAN), "diverged", "render().depth: got nan"),
    Fault("images", "depth_below_zero", "render", marred("depth", -1.0), "crashed", "render().depth: got -1.0"),
    Fault(
        "images",
        "depth_turned",
        "render",
        lambda i: replace(i, depth=i.depth.T),
        "crashed",
        "render().depth: got float64 (4, 3)",
    ),
    Fault(
        "images", "depth_of_integers", "render", told("depth", np.zeros((3, 4), int)), "crashed", "render().depth: got int64"
    ),
    Fault("images", "a_body_that_is_none", "render", told("body", np.full((3, 4), 5)), "crashed", "got body 5, expected -1..1"),
    Fault("images", "bodies_of_floats", "render", told("body", np.zeros((3, 4))), "crashed", "render().body: got float64"),
    Fault("images", "colour_nan", "render", marred("colour", NAN), "diverged", "render().colour: got nan"),
    Fault("images", "colour_inf", "render", marred("colour", INF), "diverged", "render().colour: got inf"),
    Fault("images", "colour_without_blue", "render", told("colour", np.zeros((3, 4, 2))), "crashed", "render().colour: got"),
    Fault("images", "none", "render", lambda *_: None, "crashed", "render(): got NoneType, expected Image"),
    Fault("inertial", "force_nan", "inertial", lambda _: (np.full(3, NAN), np.zeros(3)), "diverged", "accelerometer: got nan"),
    Fault("inertial", "rate_inf", "inertial", lambda _: (np.zeros(3), np.full(3, INF)), "diverged", "gyroscope: got inf"),
    Fault("inertial", "rate_huge", "inertial", lambda _: (np.zeros(3), np.full(3, HUGE)), "diverged", "gyroscope: got 1e+200"),
    Fault(
        "inertial", "two_axes", "inertial", lambda _: (np.zeros(2), np.zeros(3)), "crashed", "accelerometer: got float64 (2,)"
    ),
    Fault("inertial", "one_array", "inertial", lambda _: np.zeros(6), "crashed", "got ndarray, expected two arrays"),
    Fault("inertial", "none", "inertial", lambda _: None, "crashed", "got NoneType, expected two arrays"),
    Fault("resolved", "none", "resolved", lambda _: None, "crashed", "resolved: got NoneType, expected Settings"),
    Fault("resolved", "a_dict", "resolved", lambda _: {"dt": 0.01}, "crashed", "resolved: got dict, expected Settings"),
    Fault("resolved", "a_set", "resolved", told("options", {"a": {1}}), "crashed", "record.resolved.options.a: got {1}"),
    Fault(
        "resolved",
        "an_array",
        "resolved",
        told("options", {"a": np.zeros(2)}),
        "crashed",
        "record.resolved.options.a: got array",
    ),
    Fault("resolved", "bytes", "resolved", told("options", {"a": b"x"}), "crashed", "record.resolved.options.a: got b'x'"),
    Fault(
        "resolved", "a_number_for_a_name", "resolved", told("options", {5: 1}), "crashed", "record.resolved.options: got {5: 1}"
    ),
    Fault("resolved", "a_function", "resolved", told("solver", print), "crashed", "record.resolved.solver: got"),
    Fault(
        "resolved",
        "no_substeps",
        "resolved",
        lambda s: replace(s, substeps=0),
        "failed",
        "settings refused: settings: substeps 0",
    ),
    Fault("resolved", "a_loop", "resolved", lambda s: replace(s, options=loop()), "crashed", "RecursionError"),
    Fault(
        "resolved", "five_megabytes", "resolved", told("options", {"a": "b" * 5 * 2**20}), "crashed", "expected at most 4194304"
    ),
    Fault("warnings", "none", "warnings", lambda _: None, "crashed", "warnings(): got NoneType, expected tuple"),
    Fault("warnings", "a_text", "warnings", lambda _: "careful", "crashed", "warnings(): got str, expected tuple"),
    Fault("warnings", "numbers", "warnings", lambda _: (1, 2), "crashed", "warnings"),
    Fault("warnings", "bytes", "warnings", lambda _: (b"x",), "crashed", "warnings()[0]: got b'x'"),
    Fault("warnings", "an_exception", "warnings", lambda _: (ValueError("x"),), "crashed", "warnings()[0]: got ValueError"),
    Fault(
        "warnings",
        "ten_thousand_long_ones",
        "warnings",
        lambda _: ("careful " * 60,) * 10**4,
        "crashed",
        "expected at most 4194304",
    ),
    Fault("warnings", "a_colour", "warnings", lambda _: ("\x1b[31mred",), "passed", "every check holds"),
    Fault("warnings", "half_a_letter", "warnings", lambda _: ("\udc80",), "passed", "every check holds"),
    Fault("warnings", "raising", "warnings", raising(LookupError("nothing to say")), "crashed", "LookupError: nothing to say"),
    *(
        Fault("signals", f"{number.name.lower()}", "step", die(number), "crashed", f"killed by {number.name}")
        for number in (
            *(signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE, signal.SIGILL, signal.SIGTRAP, signal.SIGSYS),
            *(signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGPIPE, signal.SIGUSR1),
            *(signal.SIGALRM, signal.SIGXCPU, signal.SIGXFSZ, signal.SIGVTALRM),
        )
    ),
    Fault("signals", "in_real_time", "step", die(signal.SIGRTMIN + 5), "crashed", f"killed by signal {signal.SIGRTMIN + 5}"),
    Fault("exits", "exit_0", "step", doing(lambda: os._exit(0)), "crashed", "exit code 0 and no result"),
    Fault("exits", "exit_1", "step", doing(lambda: os._exit(1)), "crashed", "exit code 1 and no result"),
    Fault("exits", "exit_3", "step", doing(lambda: os._exit(3)), "crashed", "exit code 3 and no result"),
    Fault("exits", "exit_255", "step", doing(lambda: os._exit(255)), "crashed", "exit code 255 and no result"),
    Fault("exits", "sys_exit_0", "step", raising(SystemExit(0)), "crashed", "exit code 0 and no result"),
    Fault("exits", "sys_exit_with_words", "step", raising(SystemExit("enough")), "crashed", "exit code 1 and no result"),
    Fault("exits", "keyboard_interrupt", "step", raising(KeyboardInterrupt()), "crashed", "exit code 1 and no result"),
    Fault(
        "exits", "another_program", "step", doing(lambda: os.execvp("true", ["true"])), "crashed", "exit code 0 and no result"
    ),
    Fault("exits", "beyond_exceptions", "step", raising(Endless()), "crashed", "exit code 1 and no result"),
    Fault("exits", "in_build", "build", doing(lambda: os._exit(4)), "crashed", "exit code 4 and no result"),
    Fault("exits", "in_close", "close", doing(lambda: os._exit(5)), "crashed", "exit code 5 and no result"),
    Fault("raises", "in_step", "step", raising(ZeroDivisionError("of nothing")), "crashed", "ZeroDivisionError: of nothing"),
    Fault("raises", "in_build", "build", raising(OSError(28, "No space left")), "crashed", "No space left"),
    Fault("raises", "in_close", "close", raising(RuntimeError("not open")), "crashed", "RuntimeError: not open"),
    Fault("raises", "in_state", "state", raising(RuntimeError("no state")), "crashed", "RuntimeError: no state"),
    Fault("raises", "in_contacts", "contacts", raising(RuntimeError("no contacts")), "crashed", "RuntimeError: no contacts"),
    Fault(
        "raises",
        "unsupported_in_contacts",
        "contacts",
        raising(Unsupported("contacts", "lost")),
        "unsupported",
        "contacts: lost",
    ),
    Fault("raises", "unavailable_in_build", "build", raising(Unavailable("no licence")), "unavailable", "no licence"),
    Fault(
        "raises",
        "settings_in_build",
        "build",
        raising(SettingsError("settings: x 1, expected 2")),
        "failed",
        "settings refused",
    ),
    Fault("raises", "diverged_in_build", "build", raising(Diverged("at once")), "diverged", "at once"),
    Fault("raises", "diverged_in_step", "step", raising(Diverged("at last")), "diverged", "at last"),
    Fault("raises", "no_words", "step", raising(Mute()), "crashed", "Mute, whose words raise RuntimeError"),
    Fault("raises", "a_megabyte_of_words", "step", raising(RuntimeError("x" * 2**20)), "crashed", "RuntimeError: xxx"),
    Fault("raises", "right_to_left", "step", raising(RuntimeError("\u202egnorw")), "crashed", r"\u202egnorw"),
    Fault("raises", "markup", "step", raising(RuntimeError("<script>alert(1)</script>")), "crashed", "RuntimeError: <script>"),
    Fault("raises", "recursion", "step", lambda *_: deep(), "crashed", "RecursionError"),
    Fault("raises", "stop_iteration", "step", raising(StopIteration()), "crashed", "StopIteration"),
    Fault("exits", "generator_exit", "step", raising(GeneratorExit()), "crashed", "no result"),
    Fault("surroundings", "another_folder", "step", doing(lambda: os.chdir("/")), "passed", "every check holds"),
    Fault("surroundings", "no_environment", "step", doing(os.environ.clear), "passed", "every check holds"),
    Fault("surroundings", "deaf_to_signals", "step", doing(deaf), "passed", "every check holds"),
    Fault(
        "surroundings", "warnings_are_errors", "step", doing(lambda: warnings.simplefilter("error")), "passed", "every check"
    ),
    Fault("surroundings", "no_output", "step", doing(lambda: os.close(1), lambda: os.close(2)), "passed", "every check holds"),
    Fault("surroundings", "no_files", "step", doing(lambda: os.closerange(3, 4096)), "crashed", ""),
    Fault(
        "surroundings",
        "no_more_files",
        "step",
        doing(lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (3, 3))),
        "crashed",
        "Too many open files",
    ),
    Fault(
        "surroundings",
        "no_more_bytes",
        "step",
        doing(lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (10, 10))),
        "crashed",
        "RLIMIT_FSIZE: ",
    ),
    Fault("surroundings", "a_thread_that_stays", "step", doing(linger), "passed", "every check holds"),
    Fault("surroundings", "a_twin", "step", doing(twin), "passed", "every check holds"),
    Fault("processes", "a_child", "step", doing(child()), "passed", "every check holds"),
    Fault(
        "processes", "a_child_in_a_session_of_its_own", "step", doing(child(start_new_session=True)), "passed", "every check"
    ),
    Fault("processes", "a_daemon", "step", doing(daemon), "passed", "every check holds"),
    Fault("processes", "a_child_and_a_crash", "step", doing(child(), os.abort), "crashed", "killed by SIGABRT"),
    Fault("hangs", "holding_the_interpreter", "step", doing(held), "timeout", "deadline of 2 s"),
    Fault(
        "hangs",
        "deaf_with_children",
        "step",
        doing(deaf, child(), child(start_new_session=True), held),
        "timeout",
        "deadline",
    ),
    Fault("hangs", "stopped", "step", die(signal.SIGSTOP), "timeout", "deadline of 2 s"),
    Fault("hangs", "in_close", "close", doing(held), "timeout", "deadline of 2 s"),
    Fault("memory", "asked_for_in_c_and_not_used", "step", doing(malloc(2**30, 3)), "oom", "more than 400 MB: it took"),
    Fault("memory", "asked_for_until_there_is_none", "step", doing(malloc(2**33, 2**20)), "oom", "more than 400 MB: it took"),
    Fault("memory", "filled", "step", doing(filled), "oom", "more than 400 MB: it took"),
    Fault("memory", "beyond_the_machine", "step", doing(lambda: np.ones(2**45)), "oom", "MemoryError: Unable to allocate"),
    Fault("memory", "of_a_child", "step", doing(hungry_child), "oom", "more than 400 MB: it took"),
    Fault("memory", "memory_error_in_words", "step", doing(worded("MemoryError\n")), "crashed", "killed by SIGABRT"),
    Fault("memory", "bad_alloc_in_words", "step", doing(worded("std::bad_alloc\n")), "crashed", "killed by SIGABRT"),
    Fault("memory", "bad_alloc_in_an_error", "step", raising(RuntimeError("std::bad_alloc")), "crashed", "std::bad_alloc"),
)


BY_NAME = {fault.variant: fault for fault in FAULTS}
