"""The built site, which the tests of all processes share."""

from pathlib import Path

import pytest

from tests.shared import shared_folder


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the site, as `scripts/docs` builds it."""
    pytest.importorskip("zensical", reason="the extra `docs` is not installed: scripts/setup dev")
    from website.build import build

    return shared_folder(tmp_path_factory, "site", lambda folder: build(folder / "site")) / "site"
