"""Gymnasium and PettingZoo environments of the benchmark, played in this process or on a host.

Importing this package registers `arramon/ArraMon-v0` and `arramon/ArraMonRoom-v0` with Gymnasium. It needs the extra
`arramon-client[environments]`, and the server package unless `server` names a host; `docs/reference/environments.md`
has all arguments.
"""

from importlib.util import find_spec

if find_spec("gymnasium") is None:
    raise ImportError("the environments need Gymnasium: pip install 'arramon-client[environments]'")


from arramon_client.environments.backend import REWARDS
from arramon_client.environments.errors import BadArgument, NoBackend
from arramon_client.environments.labels import FactoredLabels, factored
from arramon_client.environments.registration import register
from arramon_client.environments.single import ArraMonEnv
from arramon_client.environments.tokens import ByteTokenizer, Tokenizer, WordTokenizer

__all__ = [
    "REWARDS",
    "ArraMonEnv",
    "BadArgument",
    "ByteTokenizer",
    "FactoredLabels",
    "NoBackend",
    "Tokenizer",
    "WordTokenizer",
    "factored",
    "register",
]

register()
