"""Test processes of pytest-xdist, forked from one that has imported all tests, in place of new interpreters.

Each new interpreter would import all tests again, and compile them in a fresh clone."""

import logging
import multiprocessing.forkserver
import os
import random
import sys
import traceback
from collections.abc import Sequence
from multiprocessing import resource_tracker
from typing import Any, NoReturn

import numpy as np
import pytest
from _pytest.assertion.rewrite import AssertionRewritingHook
from execnet import gateway_io
from execnet.gateway_base import Popen2IO

from tests.forked_workers import ForkedProcess, let_go_of_files

_FORKSERVER: Any = multiprocessing.forkserver._forkserver
"""The process from which the servers and clients of tests are forked (`tests.forked`): one for all test processes."""

_TRACKER: Any = resource_tracker._resource_tracker
"""Connection to the process that removes shared memory left behind: one for all as well."""

COLLECT = ("-o", "addopts=", "--collect-only", "--capture=no")
"""Options to import and collect tests, but not run them."""

WITHOUT = ("terminal", "cacheprovider", "faulthandler", "logging")
"""Plugins that are not to be there meanwhile: they would write, or put in place what the run itself has."""


def install(config: pytest.Config) -> None:
    """Import all tests that are to be run, and from now on fork the test processes of this run."""
    _FORKSERVER.ensure_running()  # It imports at the same time what servers and clients need.
    # What is wrong with a file of tests, the test processes will say.
    pytest.main([*COLLECT, *(f"-pno:{name}" for name in WITHOUT), *config.args])
    capture = config.pluginmanager.getplugin("capturemanager")

    class Tester(Popen2IO):
        """Connection to a forked test process, as execnet would start it."""

        def __init__(self, _command: Sequence[str], execmodel: Any) -> None:
            with capture.global_and_fixture_disabled():
                self.process = ForkedProcess(_test)
            streams = os.fdopen(self.process.input, "wb"), os.fdopen(self.process.output, "rb")
            super().__init__(*streams, execmodel=execmodel)
            self.wait, self.kill = self.process.wait, self.process.kill

    gateway_io.Popen2IOMaster = Tester  # type: ignore[misc, assignment]


def _test(stdin: int, stdout: int) -> NoReturn:
    """In the new process: do what the first line of input says, as execnet's command for new interpreters does."""
    status = 1
    try:
        os.dup2(stdin, 0)
        os.dup2(stdout, 1)
        let_go_of_files(_FORKSERVER._forkserver_alive_fd, _TRACKER._fd)
        _FORKSERVER.ensure_running = lambda: None  # It is the child of another process, which looks after it.
        sys.stdin, sys.stdout, sys.stderr = (os.fdopen(number, mode) for number, mode in enumerate("rww"))
        sys.meta_path = [finder for finder in sys.meta_path if not isinstance(finder, AssertionRewritingHook)]
        logging.getLogger().handlers.clear()
        random.seed()
        np.random.seed()
        exec(eval(sys.stdin.readline()), {"__name__": "__main__"})
        status = 0
    except BaseException:  # noqa: BLE001 - nothing of the parent may go on here
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(status)
