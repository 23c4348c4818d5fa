"""Causes of an episode's end. Every ended episode has exactly one, and counts in the denominator of all means."""

AGENT_FINISHED = "AGENT_FINISHED"
"""The agent ended all four phases itself."""

STEP_LIMIT = "STEP_LIMIT"
"""At least one phase was ended by the step limit."""

TIME_LIMIT = "TIME_LIMIT"
"""A time limit was reached; the remaining phases ended as at the step limit."""

FORFEITED = "FORFEITED"
"""The participant forfeited the episode, cancelled the run, or did not reconnect."""

SERVER_FAULT = "SERVER_FAULT"
"""The server failed on the episode; never counted against the participant."""
