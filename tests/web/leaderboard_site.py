"""A web site with published runs on an open and a hidden split, some of them really played."""

from contextlib import closing
from dataclasses import asdict, replace
from pathlib import Path

from arramon_server.board.board import Board
from arramon_server.episodes.episode import Episode, Instructions
from arramon_server.episodes.splits import Split, write_split
from arramon_server.runs.accounts.callers import HOST
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.results.receipts import Receipts
from arramon_server.runs.results.signing import SigningKey
from arramon_server.runs.storage.records import COMPLETE, RUNNING, CodeReference, CommitBatch, EpisodeEnding, Run
from arramon_server.scoring.episode_scores import METRICS
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.city import city_scene
from arramon_server.sim.geometry import Point, Pose
from arramon_server.sim.physics import physics_of
from arramon_server.sim.rules import Collectible, Limits
from arramon_server.web.pages import Pages
from tests import tiny
from tests.board.leaderboard_backend import CLOCKS, NOON, STEPS, LeaderboardBackend, secret_of
from tests.web.serving import Site

OLDER_RUN, REPRODUCED_RUN = "6" * 32, "1" * 32
OPEN_RUN, HIDDEN_RUN, UNPUBLISHED_RUN, WITHDRAWN_RUN, PRIVILEGED_RUN = (letter * 32 for letter in "abcdf")
ODD = 0.4375
"""A peculiar episode's places are all off by so much."""

PECULIAR = ("quokka", "hourglass", "purple", "रेतघड़ी", "26.44")
"""What stands on the pages of peculiar episodes, and nowhere else: ids, objects, instructions, and a place on a map."""


class LeaderboardSite(LeaderboardBackend):
    """A backend and its site.

    Attributes:
        site: its pages, served.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.folder = folder
        for name, hidden in (("open", False), ("hidden", True)):
            self.splits[name] = peculiar_split(folder, name, hidden=hidden)
        self.receipts = Receipts(self.database, self.splits, SigningKey(folder / "key.pem"))
        self.site = self._served()

    def restart(self, **splits: Split) -> None:
        """Serves the same journal again, with these splits, too, or in place of what they were."""
        self.site.close()
        self.splits |= splits
        self.site = self._served()

    def _served(self) -> Site:
        self.board = Board(self.entries, self.splits, steps_per_phase=STEPS, clocks=CLOCKS)
        return Site(Pages(self.board, self.journal, self.receipts, self.splits, self.epoch_board))

    def play(
        self, run_id: str, split: str, language: str = "en", *, sensors: tuple[str, ...] = ("rgb", "depth")
    ) -> str:
        """Plays the ground truth in every episode of a split, and publishes the run."""
        order = self.splits[split].in_playing_order(language)
        run = Run(
            run_id=run_id, participant="lab", agent="truth", split=split, language=language, sensors=sensors,
            steps_per_phase=STEPS, data_hash=self.splits[split].data_hash, server_version="9", state=RUNNING,
            created_at=NOON, **asdict(CLOCKS), agent_arguments=(("beam", "4"), ("checkpoint", "my w.pt")),
        )  # fmt: skip
        self.journal.create(run, [episode.episode_id for episode in order])
        with closing(physics_of(city_scene(tiny.SECTION))) as ground:
            for episode in order:
                self.journal.commit(_played(run_id, EpisodeSession(episode, ground, Limits(STEPS))))
        self.journal.set_state(run_id, COMPLETE)
        return self.publish(run_id)

    def season(self) -> None:
        """Opens two epochs, the first one revealed; publishes runs of one agent on both, and reproductions."""
        self.participant("ann", "bob", "cid")
        older, newer = (self.epoch(number, self.folder, 12) for number in (1, 2))
        self.restart()
        code = CodeReference("https://example.org/walker", "c" * 40)
        runs = {
            (older, OLDER_RUN, "ann"): 1.0,
            (newer, REPRODUCED_RUN, "ann"): 0.75,
            (newer, "2" * 32, "bob"): 0.5,
            (newer, "3" * 32, "cid"): 0.75,
        }
        for (split, run_id, who), score in runs.items():
            self.run(run_id, score, split=split, participant=who, account=who, code=code)
            reproduces = REPRODUCED_RUN if who != "ann" else None
            self.publisher.publish(HOST, run_id, "", reproduces=reproduces)
        for split, number in ((older, "4"), (newer, "5")):
            self.publish(self.run(number * 32, 0.25, split=split, agent="other", participant="bob", account="bob"))
        self.epochs.close(older)
        self.epochs.reveal(older, secret_of(1))

    def fill(self) -> None:
        """Publishes what most tests look at."""
        self.season()
        self.play(OPEN_RUN, "open")
        self.play(HIDDEN_RUN, "hidden")
        self.published(1, 1.0, "both-hands", language="hi", split="open", participant="<i>lab</i>")
        self.published(2, 0.5, "both-hands", language="en", split="open", participant="<i>lab</i>")
        self.published(3, 0.5, "half", split="hidden", language="hi")
        self.run(UNPUBLISHED_RUN, split="open")
        self.publish(self.run(WITHDRAWN_RUN, split="open"))
        self.publisher.withdraw(HOST, WITHDRAWN_RUN)
        for number, (agent, score) in enumerate({"middle": 0.5, "worst": 0.0, "best": 1.0}.items(), start=4):
            self.published(number, score, agent, participant="एक प्रयोगशाला")
        self.publish(
            self.run(PRIVILEGED_RUN, agent="seer", sensors=("rgb", "oracle")), "Code: https://example.org/seer"
        )

    def published(self, number: int, score: float, agent: str, **more: str) -> str:
        """A published run of this number whose episodes all have one score."""
        return self.publish(self.run(f"{number:032x}", score, agent=agent, **more))  # type: ignore[arg-type]


def peculiar_split(folder: Path, name: str, *, hidden: bool) -> Split:
    """A split whose episodes, objects and places cannot be mistaken for anything else."""
    episodes = [_peculiar(number) for number in range(3)]
    return write_split(folder, name, hidden=hidden, source="tests", episodes=episodes, sections=[tiny.SECTION])


def _peculiar(number: int) -> Episode:
    plain = tiny.episode(f"quokka-{number}")
    texts = {
        "en": Instructions("Go on to the dotted purple hourglass.", "Put the hourglass two steps ahead."),
        "hi": Instructions("बिंदीदार बैंगनी रेतघड़ी तक चलें।", "रेतघड़ी को दो क़दम आगे रखें।"),
    }
    turns = tuple(
        replace(
            turn,
            path=tuple((x + ODD, z) for x, z in turn.path),
            street=tuple(
                Collectible(
                    ObjectType("dotted", "purple", "hourglass"),
                    Point(item.position.x + ODD, item.position.y, item.position.z),
                )
                for item in turn.street
            ),
        )
        for turn in plain.turns
    )
    return replace(
        plain,
        start=Pose(ODD, 0.0, 0.0),
        turns=(turns[0], turns[1]),
        instructions={code: (text, text) for code, text in texts.items()},
    )


def _played(run_id: str, session: EpisodeSession) -> CommitBatch:
    """All steps of an episode's ground truth, and its ending."""
    batch, episode = CommitBatch(), session.episode
    actions = [action for turn in episode.turns for action in (*turn.actions, *turn.room_actions)]
    for step, action in enumerate(actions):
        session.apply(action)
        batch.add_step(run_id, episode.episode_id, 0, step, action)
    scores = [dict(turn) for turn in session.scores().turns]
    assert set(scores[0]) == set(METRICS)
    batch.endings.append(EpisodeEnding(run_id, episode.episode_id, "AGENT_FINISHED", len(actions), scores))
    return batch
