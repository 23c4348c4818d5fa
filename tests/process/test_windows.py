"""What needs Unix says so on Windows, before it imports anything that Windows does not have."""

import subprocess
import sys

import pytest

from tests import ROOT

WINDOWS = "import os; os.name = 'nt'"


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (
            f"import sys, arramon_server.__main__; {WINDOWS}; sys.exit(arramon_server.__main__.main(['serve']))",
            "error: arramon-server needs Linux or macOS: on Windows run it in WSL 2",
        ),
        (
            f"import arramon_client.errors, arramon_server; {WINDOWS}; import arramon_dataset.environments",
            "arramon_client.errors.UsageError: environments in this process need Linux or macOS: on Windows use WSL 2, "
            "or name a host with server='HOST:PORT'",
        ),
        (
            f"from arramon_client.local.embedded import check_installed; {WINDOWS}; check_installed('server')",
            "arramon_client.errors.EmbeddedServerError: without --server the client starts an embedded server, which "
            "needs Linux or macOS: on Windows use WSL 2, or name a server with --server HOST:PORT",
        ),
    ],
    ids=["server", "environments", "embedded server"],
)
def test_what_needs_unix_says_so(code: str, said: str) -> None:
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode in (1, 2)
    assert done.stderr.splitlines()[-1] == said


def test_on_unix_nothing_of_that_is_said() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "import arramon_dataset.environments; import arramon_server.__main__"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
