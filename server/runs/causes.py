"""Why an episode ended. Every episode of a run ends with exactly one cause, and stays in the denominator."""

AGENT_FINISHED = "AGENT_FINISHED"
"""The agent ended all four phases itself."""

STEP_LIMIT = "STEP_LIMIT"
"""At least one phase was ended by the step limit."""

TIME_LIMIT = "TIME_LIMIT"
"""A clock ran out; the phases that were left ended as at the step limit."""

FORFEITED = "FORFEITED"
"""The participant gave the episode up, cancelled the run, or never came back."""

SERVER_FAULT = "SERVER_FAULT"
"""The server could not go on; never charged to the participant."""
