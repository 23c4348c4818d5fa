"""Adapters whose framework is not installed name the extra that brings it."""

from importlib import import_module
from importlib.util import find_spec

import pytest

from arramon_client.errors import UsageError


@pytest.mark.parametrize(
    ("module", "framework", "extra"),
    [
        ("inspect_task", "inspect_ai", "inspect"),
        ("openenv.environment", "openenv", "openenv"),
        ("openenv.client", "openenv", "openenv"),
        ("verifiers", "verifiers", "verifiers"),
    ],
)
def test_the_error_names_the_extra(module: str, framework: str, extra: str) -> None:
    assert find_spec(framework) is None  # Here; the other tests install it in an environment of its own.
    with pytest.raises(UsageError) as caught:
        import_module(f"arramon_client.adapters.{module}")
    assert str(caught.value).endswith(f"install the extra {extra!r}, with pip install 'arramon-client[{extra}]'")
