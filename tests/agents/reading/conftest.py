"""Require PyTorch, and limit it to one thread: several test processes share the cores."""

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")
torch.set_num_threads(1)
