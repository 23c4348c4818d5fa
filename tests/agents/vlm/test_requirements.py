"""The extra: nothing of it is imported before the agent is made, and torch never."""

import subprocess
import sys
from importlib.machinery import ModuleSpec
from importlib.util import find_spec

import pytest

from arramon_agents import requirements
from arramon_client.errors import AgentLoadError
from tests import ROOT
from tests.agents.vlm.conftest import MakeAgent

CODE = """
import sys
import arramon_agents.vlm
assert not {"torch", "openai", "httpx2", "PIL"} & sys.modules.keys()
arramon_agents.vlm.make_agent(model="m", endpoint="http://localhost:1/v1", trace=sys.argv[1])
assert "openai" in sys.modules
print([name for name in ("torch", "arramon_server", "arramon_dataset") if name in sys.modules])
"""


def test_neither_torch_nor_the_server_is_imported(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = str(tmp_path_factory.mktemp("trace"))
    done = subprocess.run([sys.executable, "-c", CODE, folder], capture_output=True, text=True, cwd=ROOT, check=False)
    assert (done.stdout.strip(), done.returncode) == ("[]", 0), done.stderr


def test_without_the_extra_the_message_names_it(made: MakeAgent, monkeypatch: pytest.MonkeyPatch) -> None:
    def found(name: str) -> ModuleSpec | None:
        return None if name == "openai" else find_spec(name)

    monkeypatch.setattr(requirements, "find_spec", found)
    with pytest.raises(AgentLoadError, match=r"agents\.vlm needs openai: .*`pip install 'arramon-agents\[vlm\]'`"):
        made()
