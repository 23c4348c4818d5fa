"""The task set under a name that verifiers can load: `vf-eval arramon-verifiers --env.taskset.lang hi`."""

from arramon_client.adapters.verifiers import ArramonEnv, ArramonTaskset

__all__ = ["ArramonEnv", "ArramonTaskset"]
