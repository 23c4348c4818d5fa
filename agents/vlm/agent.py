"""The agent: asks a language model for plans of actions, and carries them out."""

import logging
import random
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import openai

from arramon_agents.vlm import notes, sight
from arramon_agents.vlm.caller import EndpointCaller
from arramon_agents.vlm.episode_state import EpisodeState, task_text
from arramon_agents.vlm.messages import Conversation, ConversationWriter, ModelExchange
from arramon_agents.vlm.prompt_texts import PromptFolder, Prompts
from arramon_agents.vlm.records import PaidReply
from arramon_agents.vlm.replies import (
    TOOL,
    ModelDecision,
    Reply,
    UnusableReplyError,
    answer_form,
    read_decision,
    schema,
    written,
)
from arramon_agents.vlm.scene import describe
from arramon_agents.vlm.settings import ModelSettings, check_folder, read_key
from arramon_agents.vlm.trace import SUFFIX, CallTrace
from arramon_agents.vlm.usage import read_price
from arramon_client.agent import Action, Answer, Episode, Observation
from arramon_client.errors import AgentLoadError, StopRun

if TYPE_CHECKING:
    from arramon_client.runs.info import RunInfo

PURPOSES = ("act", "again")
"""Purposes of the calls before a step, in order: the question, and one more after an unusable reply."""

NO_STEP = -1
"""Step of the calls of the sight check, in the trace."""

DEFAULT_FOLDER = "arramon-results"
"""Folder of the trace where a run has no folder for results."""

_log = logging.getLogger("arramon_agents.vlm")


class VlmAgent:
    """Agent that asks a language model behind an OpenAI-compatible endpoint.

    Args:
        settings: checked settings.

    Raises:
        AgentLoadError: if there is no key, or a file cannot be read.
    """

    def __init__(self, settings: ModelSettings) -> None:
        self._settings = settings
        self._key = read_key(settings)
        self._price = read_price(settings.prices, settings.model)
        self._prompts = PromptFolder(settings.prompts, _log.warning)
        self._folder = check_folder(settings.trace) if settings.trace is not None else None
        self._writer = ConversationWriter(settings)
        self._caller: EndpointCaller | None = None
        self._states: dict[str, EpisodeState] = {}
        self._noops: dict[tuple[str, int], str] = {}
        self._sight = ""
        self._report: Mapping[str, Any] = {}
        self._used = ""
        self.name = f"vlm {settings.model}"
        self.sensors: Sequence[str] = ("rgb",) if settings.images else ("depth", "segmentation")
        if settings.prices is not None and self._price is None:
            if settings.max_cost is not None:
                raise AgentLoadError(
                    f"agents.vlm: {settings.prices} has no prices of {settings.model!r}, so max_cost cannot be kept"
                )
            _log.warning("agents.vlm: %s has no prices of %s: costs are unknown", settings.prices, settings.model)

    @property
    def recorded_arguments(self) -> Mapping[str, str]:
        """What the run records as the agent's arguments: those that may change its play, and what it asks with."""
        settings = self._settings
        own = {} if settings.seed is not None else {"seed": "none"}
        return {**settings.recorded(), **own, "prompts": self._prompts.digest, "openai": openai.__version__}

    async def open(self, run: "RunInfo") -> None:
        """Open the run's trace, and check that the model sees.

        Args:
            run: the run.

        Raises:
            StopRun: if the trace cannot be opened, or the model does not see.
        """
        folder = self._folder or check_folder(run.output or DEFAULT_FOLDER)
        trace = CallTrace(folder / f"{run.run_id}{SUFFIX}")
        if run.steps and not trace.records:
            _log.warning(
                "agents.vlm: %s has no calls of the run's %d earlier steps: usage and limits count from here. If the "
                "trace is in another folder, stop, and resume with --agent-arg trace=DIR",
                trace.path,
                run.steps,
            )
        self._states.clear()
        self._noops.clear()
        self._caller = EndpointCaller(self._settings, self._key, self._price, trace)
        for record in trace.records:
            if record.get("kind") == "noop":
                self._noops[str(record.get("episode")), int(record.get("step", 0))] = str(record.get("unusable"))
        self._caller.trace.write(
            {"kind": "start", "run": run.run_id, "language": run.language, **dict(self.recorded_arguments)}
        )
        try:
            shown = self._settings.images and "rgb" in run.sensors
            self._sight = await self._check_sight(self._prompts.of(run.language)) if shown else "none"
        except BaseException:  # Another process, or the next run of this one, may open the trace again.
            await self.close()
            raise

    async def close(self) -> None:
        """Close trace and connections."""
        if self._caller is not None:
            await self._caller.close()
            self._report, self._used, self._caller = self._state(self._caller), _line(self._caller), None

    def begin(self, episode: Episode) -> None:
        """Start an episode without a history."""
        prompts = self._prompts.of(episode.language)
        self._states[episode.episode_id] = EpisodeState(episode, prompts, self._settings.window)

    def end(self, episode_id: str) -> None:
        """Discard the state of an episode, and trace its end, so that an estimate counts whole episodes only."""
        self._states.pop(episode_id, None)
        self._need_caller().trace.write({"kind": "end", "episode": episode_id})

    async def act(self, observation: Observation) -> Action | Answer:
        """Return the next action of the plan, after asking for a new plan if there is none.

        Raises:
            StopRun: if a limit is reached, or the endpoint cannot answer any call.
            AgentError: if this call failed for a cause that may pass.
        """
        state = self._states[observation.episode_id]
        state.observe(observation)
        if state.plan:
            return state.take()
        exchange = self._question(state, observation)
        replies, decision, cause = await self._ask(state, observation, exchange)
        if decision is None:
            self._count_noop(observation, cause)
        state.decide(exchange, replies[-1].reply, decision)
        note = notes.write(decision, cause, replies, self._price, self._sight)
        return Answer(state.take(), note)

    def replay(self, observation: Observation, action: int) -> None:
        """Restore the history of a recorded step, from the trace or else from the step's note, without a call."""
        state = self._states[observation.episode_id]
        state.observe(observation)
        if state.plan and state.plan[0] != action:  # Another client played on from here.
            state.plan.clear()
        if not state.plan:
            exchange = self._question(state, observation)
            reply, decision = self._restored(observation, Action(action))
            state.decide(exchange, reply, decision)
            if state.plan[0] != action:
                state.plan.clear()
                state.plan.append(Action(action))
        state.take()

    def run_report(self) -> Mapping[str, Any]:
        """Return what the results file keeps of the run: usage, no-ops by cause, sight check and trace."""
        return self._report if self._caller is None else self._state(self._caller)

    def run_summary(self) -> str:
        """Return a line on what the run has used so far; empty before the first run."""
        return self._used if self._caller is None else _line(self._caller)

    def _state(self, caller: EndpointCaller) -> Mapping[str, Any]:
        noops = dict(sorted(Counter(self._noops.values()).items()))
        return {**caller.usage.as_json(), "noops": noops, "sight": self._sight, "trace": str(caller.trace.path)}

    def _question(self, state: EpisodeState, observation: Observation) -> ModelExchange:
        shown = self._settings.images and observation.rgb is not None
        scene = "" if shown else describe(observation, state.episode.labels, state.prompts)
        return state.question(observation, scene)

    def _conversation(self, state: EpisodeState, observation: Observation, exchange: ModelExchange) -> Conversation:
        prompts, settings = state.prompts, self._settings
        kind = "tools" if settings.answers == "tools" else "json"
        answer = prompts.text(f"answer.{kind}", plan=settings.plan)
        system = "\n\n".join((prompts.text("system"), answer, task_text(observation, prompts)))
        form = answer_form(settings.answers, TOOL, prompts.text("answer.tool"), schema(prompts))
        return self._writer.conversation(system, state.exchanges, exchange, form)

    async def _ask(
        self, state: EpisodeState, observation: Observation, exchange: ModelExchange
    ) -> tuple[list[PaidReply], ModelDecision | None, str]:
        """Ask for a plan, again after an unusable reply; return the replies, the decision, and why there is none."""
        caller, settings, cause = self._need_caller(), self._settings, ""
        conversation = self._conversation(state, observation, exchange)
        replies: list[PaidReply] = []
        for purpose in PURPOSES:
            paid = await caller.ask(purpose, observation.episode_id, observation.step, conversation, self._read)
            replies.append(paid)
            try:
                return replies, self._read(paid.reply), ""
            except UnusableReplyError as error:
                cause = error.cause
                conversation = conversation.again(paid.reply, state.prompts, cause, settings.plan)
        return replies, None, cause

    def _read(self, reply: Reply) -> ModelDecision:
        return read_decision(reply, self._settings.answers, self._settings.plan)

    def _restored(self, observation: Observation, action: Action) -> tuple[Reply, ModelDecision | None]:
        """Return the reply and the decision behind a recorded action, as far as they are known."""
        replies = self._need_caller().paid.at(observation.episode_id, observation.step)
        unusable = Reply("")
        for paid in replies:
            try:
                decision = self._read(paid.reply)
            except UnusableReplyError:
                continue
            if decision.plan[0] == action:
                return paid.reply, decision
        if replies and len(replies) >= len(PURPOSES):
            return unusable, None
        noted = notes.read(observation.taken_note, self._settings.plan)
        if noted is None:
            noted = ModelDecision("", (action,))
        if noted == notes.NOOP:
            return unusable, None
        text = written(noted)
        if self._settings.answers == "tools":
            return Reply("", ((TOOL, text),), ("restored",)), noted
        return Reply(text), noted

    def _count_noop(self, observation: Observation, cause: str) -> None:
        key = (observation.episode_id, observation.step)
        if key in self._noops:  # It was counted before the client was killed.
            return
        self._noops[key] = cause
        record = {"kind": "noop", "episode": observation.episode_id, "step": observation.step, "unusable": cause}
        self._need_caller().trace.write(record)

    def _need_caller(self) -> EndpointCaller:
        if self._caller is None:
            raise RuntimeError("agents.vlm was called before open(run)")
        return self._caller

    async def _check_sight(self, prompts: Prompts) -> str:
        """Return "passed", "blind" or "skipped".

        Raises:
            StopRun: if the model does not see, and the setting is "check".
        """
        settings = self._settings
        if settings.sight == "skip":
            return "skipped"
        form = answer_form(settings.answers, sight.TOOL, prompts.text("sight.question"), sight.schema())
        tool = sight.TOOL if settings.answers == "tools" else None
        for number in range(sight.CARDS):
            card = sight.draw_card(random.Random(f"{settings.model}/{settings.seed}/{number}"))  # noqa: S311
            text = sight.question(prompts, settings.answers)
            exchange = ModelExchange(text, sight.picture(card), f"sight/{number}")
            conversation = self._writer.conversation(prompts.text("system"), (), exchange, form)
            paid = await self._need_caller().ask("sight", "", NO_STEP, conversation, None)
            if card.is_named_by(paid.reply, tool):
                return "passed"
        if settings.sight == "check":
            raise StopRun(
                f"the model {settings.model} at {settings.endpoint} does not see: it named none of {sight.CARDS} cards "
                "rightly. Start a new run: with a model that does, with words in place of frames (--agent-arg "
                "images=false), or with a mark (--agent-arg sight=mark)"
            )
        _log.warning("agents.vlm: the model does not see the frames; the run is marked")
        return "blind"


def _line(caller: EndpointCaller) -> str:
    return f"agents.vlm: {caller.usage.summary()}; trace: {caller.trace.path}"
