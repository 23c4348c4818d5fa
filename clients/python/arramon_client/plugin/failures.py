"""Counting of an agent's failures in a run, and the rule that stops the run.

The rule: the agent failed before its first valid action, or in `FAILURES_IN_A_ROW` consecutive episodes.
"""

import threading

from arramon_client.errors import AgentError, AgentStoppedError

FAILURES_IN_A_ROW = 3
"""Number of consecutive failed episodes that stops a run. A failed batch counts each of its episodes; an episode that
ends without a failure resets the count."""


class FailureCounter:
    """Counter of an agent's failures over all streams of a run.

    Args:
        keep_going: never stop the run; each failure only gives up its episodes.
    """

    def __init__(self, *, keep_going: bool) -> None:
        self._keep_going = keep_going
        self._lock = threading.Lock()
        self._acted = False
        self._in_a_row = 0

    def record_actions(self) -> None:
        """Record that the agent returned valid actions."""
        self._acted = True

    def record_end(self) -> None:
        """Record that an episode ended without a failure of the agent."""
        with self._lock:
            self._in_a_row = 0

    def record_failure(self, episodes: int, error: AgentError) -> None:
        """Record that the agent failed in this number of episodes, which the caller then gives up.

        Raises:
            AgentStoppedError: if the run must stop instead.
        """
        if self._keep_going:
            return
        with self._lock:
            self._in_a_row += episodes
            if not self._acted:
                when = "before its first valid action"
            elif self._in_a_row >= FAILURES_IN_A_ROW:
                when = f"in {self._in_a_row} episodes in a row"
            else:
                return
        raise AgentStoppedError(f"run stopped: the agent failed {when}: {error}", error.details) from error
