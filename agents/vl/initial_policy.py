"""Initial policy of a training: new random weights, or existing weights to fine-tune."""

from collections.abc import Sequence
from dataclasses import replace

import torch

from arramon_agents.perception.encoder import VisualEncoder
from arramon_agents.perception.registry import open_encoder
from arramon_agents.pretrained.hidden_state_cache import open_hidden_state_cache
from arramon_agents.reading.text_encoders import PretrainedTextEncoder, encoder_ids
from arramon_agents.reading.tokenizers import PRETRAINED, UNKNOWN, PolicyWordTokenizer, train_tokenizer
from arramon_agents.training.recipe import as_json
from arramon_agents.training.workspace import Report, Workspace
from arramon_agents.vl.config import ModelConfig
from arramon_agents.vl.model import Model
from arramon_agents.vl.policy import VlPolicy, load_policy
from arramon_agents.vl.recipe import Recipe
from arramon_agents.weights import find_initial
from arramon_client.world import PHASES


def initial_policy(recipe: Recipe, texts: Sequence[str], workspace: Workspace, report: Report) -> VlPolicy:
    """Return the policy of a recipe before the first update, on the training device.

    Args:
        recipe: training settings; `init` names weights to fine-tune.
        texts: training texts.
        workspace: has the device, and the cache folder for states of a frozen text encoder.
        report: receives lines of progress.

    Raises:
        ValueError: if the initial weights are of another model, or cannot be read.
    """
    encoder = open_encoder(recipe.encoder) if recipe.sees else None
    policy = extended_policy(recipe, encoder, texts) if recipe.init else _new(recipe, encoder, texts)
    policy.model.to(workspace.device)
    if recipe.reads and recipe.reader.startswith(PRETRAINED):
        states = open_hidden_state_cache(recipe.reader.removeprefix(PRETRAINED))
        pieces = (encoder_ids(policy.tokenizer.encode(text)) for text in texts)
        moments = states.prepare(pieces, workspace.cache, report, recipe.precision)
        for module in map(policy.model.of, () if recipe.init else PHASES):
            assert isinstance(module.reader, PretrainedTextEncoder)
            module.reader.standardise(*moments)
    return policy


def extended_policy(recipe: Recipe, encoder: VisualEncoder | None, texts: Sequence[str]) -> VlPolicy:
    """Return the policy of a recipe's initial weights, with new words of the texts added to its vocabulary.

    A new word gets the embedding of the unknown word. Tokenizers other than "word" stay as they are.

    Raises:
        ValueError: if the weights are of another model, or cannot be read.
    """
    path = find_initial(recipe.init, recipe.agent)
    known = load_policy(path)
    own, wanted = known.model.config, _config(recipe, encoder, known.tokenizer.size)
    eyes, wanted_eyes = (None if each is None else each.name for each in (known.encoder, encoder))
    kinds = known.tokenizer.name, recipe.tokenizer.partition("=")[0]
    if own != wanted or eyes != wanted_eyes or kinds[0] != kinds[1]:
        raise ValueError(
            f"{path} is of another model than the recipe: {own}, encoder {eyes}, tokenizer {kinds[0]}; expected "
            f"{wanted}, encoder {wanted_eyes}, tokenizer {kinds[1]}"
        )
    tokenizer = (
        known.tokenizer.with_new_words(texts) if isinstance(known.tokenizer, PolicyWordTokenizer) else known.tokenizer
    )
    model, weights = Model(replace(own, vocabulary=tokenizer.size)), known.model.state_dict()
    for name, value in weights.items():
        if name.endswith("reader.embedding.weight"):
            weights[name] = torch.cat([value, value[UNKNOWN].repeat(tokenizer.size - len(value), 1)])
    model.load_state_dict(weights)
    return VlPolicy(model, tokenizer, encoder, {"recipe": as_json(recipe)})


def _new(recipe: Recipe, encoder: VisualEncoder | None, texts: Sequence[str]) -> VlPolicy:
    tokenizer = train_tokenizer(recipe.tokenizer, texts)
    return VlPolicy(Model(_config(recipe, encoder, tokenizer.size)), tokenizer, encoder, {"recipe": as_json(recipe)})


def _config(recipe: Recipe, encoder: VisualEncoder | None, vocabulary: int) -> ModelConfig:
    return ModelConfig(
        vocabulary=vocabulary,
        channels=encoder.channels if encoder else 0,
        sees=recipe.sees,
        reads=recipe.reads,
        positions=True,
        reader=recipe.reader,
    )
