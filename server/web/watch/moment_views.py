"""Moments in a reader's language, as plain data for the page and its scripts."""

from collections.abc import Mapping, Sequence
from typing import Any

from arramon_client.world import Action
from arramon_server.episodes.episode import Episode
from arramon_server.playback.moments import Moment, MomentMark, Playback
from arramon_server.scoring.metrics import placement_distance
from arramon_server.sim.room import RoomCell
from arramon_server.sim.rules import Blocked, Event, Phase, PhaseEnded, PickedUp, Placed
from arramon_server.sim.section import Section
from arramon_server.web.named_things import object_name
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.room_map import cell_centre
from arramon_server.web.section_map import place_on_map
from arramon_server.web.watch.shown_notes import ShownNote, is_cell, shown_note
from arramon_server.web.watch.stage import from_start

ACTIONS = {
    Action.FORWARD: "forward",
    Action.LEFT: "left",
    Action.RIGHT: "right",
    Action.INTERACT: "interact",
}
"""Names of the actions, as keys of texts."""

TRUTH_MARKS = (MomentMark.LEFT, MomentMark.BACK)
"""Marks that tell something of the reference path."""


class MomentViews:
    """Views of an episode's moments.

    Args:
        t: texts of the page's language.
        episode: the episode.
        section: its section.
        playback: its moments.
        notes: notes of its agent, by step.
        steps_per_phase: step limit of a phase.
        shows_truth: whether to show what depends on the ground truth.
        shows_places: whether to show places and headings, from which a map is drawn.

    Attributes:
        moments: the moments, as of now.
    """

    def __init__(
        self,
        t: PageTexts,
        episode: Episode,
        section: Section,
        playback: Playback,
        notes: Mapping[int, str],
        steps_per_phase: int,
        *,
        shows_truth: bool,
        shows_places: bool = True,
    ) -> None:
        self._t = t
        self._episode = episode
        self._section = section
        self.moments = playback.moments
        self._notes = {step: shown_note(t, note) for step, note in notes.items()}
        self._steps_per_phase = steps_per_phase
        self._shows_truth = shows_truth
        self._shows_places = shows_places
        self._note_at, self._reading_at = self._applicable()

    @property
    def last(self) -> int:
        """Number of the last moment."""
        return len(self.moments) - 1

    def view(self, step: int) -> dict[str, Any]:
        """Return one moment.

        Keys: `step`, `turn`, `phase`, `place` ([x, y] on the map of its phase) and `heading` (degrees; both None if not
        shown), `action` and `answer` (texts), `left` (steps), `carried` (text), `ndtw` and `distance` (texts; empty if
        not shown), `marks`, `note` and `reading` (the steps of the notes that apply; -1 for none).
        """
        moment = self.moments[step]
        state, t = moment.state, self._t
        in_room = state.phase is Phase.ASSEMBLY
        marks = [mark for mark in moment.marks if self._shows_truth or mark not in TRUTH_MARKS]
        return {
            "step": step,
            "turn": state.turn,
            "phase": state.phase.value,
            "place": self._place(moment) if self._shows_places else None,
            "heading": round(state.room_heading if in_room else state.pose.heading) if self._shows_places else None,
            "action": self._action_text(moment),
            "answer": self._answer(moment),
            "left": max(self._steps_per_phase - state.phase_step, 0),
            "carried": object_name(t, state.carried) if state.carried is not None else "",
            "ndtw": t.score(moment.ndtw) if self._shows_truth else "",
            "distance": self._distance(step) if self._shows_truth else "",
            "marks": [mark.value for mark in marks],
            "note": self._note_at[step],
            "reading": self._reading_at[step],
        }

    def trail(self, step: int) -> list[tuple[float, float]]:
        """Return the places on the map from the beginning of a moment's phase up to the moment."""
        state = self.moments[step].state
        return [
            self._place(one)
            for one in self.moments[: step + 1]
            if (one.state.turn, one.state.phase) == (state.turn, state.phase)
        ]

    def note(self, step: int) -> dict[str, Any]:
        """Return the note of a step. Keys: `facts`, `text`, `goal` ([x, y] on the map, or None), `step`, `reading`."""
        note = self._notes[step]
        return {
            "facts": note.facts,
            "text": note.text,
            "goal": self._goal(step, note),
            "step": note.step,
            "reading": note.reading,
        }

    def notes_from(self, first: int) -> dict[int, dict[str, Any]]:
        """Return the notes of all steps from `first` on."""
        return {step: self.note(step) for step in sorted(self._notes) if step >= first}

    def _place(self, moment: Moment) -> tuple[float, float]:
        state = moment.state
        if state.phase is Phase.ASSEMBLY:
            return cell_centre(state.square)
        return place_on_map(self._section, (state.pose.x, state.pose.z))

    def _applicable(self) -> tuple[list[int], list[int]]:
        """Return for each moment the step of the latest note of its phase, and of the latest one with a reading."""
        notes, readings = list[int](), list[int]()
        note = reading = -1
        phase: tuple[int, Phase] | None = None
        for step, moment in enumerate(self.moments):
            here = moment.state.turn, moment.state.phase
            if here != phase:
                phase, note, reading = here, -1, -1
            if step in self._notes:
                note = step
                reading = step if self._notes[step].reading else reading
            notes.append(note)
            readings.append(reading)
        return notes, readings

    def _goal(self, step: int, note: ShownNote) -> tuple[float, float] | None:
        if note.goal is None or not self._shows_places or step >= len(self.moments):
            return None
        if self.moments[step].state.phase is Phase.ASSEMBLY:
            return cell_centre(RoomCell(*map(int, note.goal))) if is_cell(note.goal) else None
        return place_on_map(self._section, from_start(self._episode.start, note.goal))

    def _action_text(self, moment: Moment) -> str:
        if moment.action is None:
            return ""
        name = ACTIONS[moment.action]
        if moment.action is Action.INTERACT:
            name = "place" if moment.state.phase is Phase.ASSEMBLY else "pick_up"
        return self._t(f"actions.{name}")

    def _answer(self, moment: Moment) -> str:
        """Return what the rules answered, in one or two sentences; empty for a step that simply happened."""
        if moment.action is Action.INTERACT and not moment.events:
            return self._t("answers.no_place" if moment.state.phase is Phase.ASSEMBLY else "answers.out_of_reach")
        said = [self._event_text(moment, event) for event in moment.events]
        return " ".join(filter(None, said))

    def _event_text(self, moment: Moment, event: Event) -> str:
        t = self._t
        match event:
            case Blocked():
                return t("answers.blocked")
            case PickedUp(index):
                street = self._episode.turns[moment.state.turn - 1].street
                return t("answers.picked_up", object=object_name(t, street[index].type))
            case Placed(cell):
                return t("answers.placed", column=cell.column + 1, row=cell.row + 1, level=cell.level)
            case PhaseEnded(forced=True):
                return t("answers.forced")
        return ""

    def _distance(self, step: int) -> str:
        """Return how far the agent is from its target; once it has placed its object, how far that is off."""
        moment = self.moments[step]
        # An episode that is over shows how its last action ended.
        events = self.moments[step - 1].events if moment.state.finished and step else moment.events
        placed = next((event for event in events if isinstance(event, Placed)), None)
        is_forced = any(isinstance(event, PhaseEnded) and event.forced for event in events)
        if placed is not None and not is_forced:
            target = self._episode.turns[moment.state.turn - 1].target_cell
            off = placement_distance(placed.placement, target)
            return self._t("watch.placed_off", number=off) if off else self._t("watch.placed_exactly")
        if moment.state.phase is Phase.ASSEMBLY:
            return self._t("watch.cells", number=round(moment.distance))
        return self._t("watch.units", number=self._t.decimal(round(moment.distance, 1)))


def notable_steps(moments: Sequence[Moment], *, shows_truth: bool = True) -> list[tuple[int, MomentMark]]:
    """Return the steps at which something stands out, with what; of blocked steps in a row the first.

    Args:
        moments: the moments.
        shows_truth: whether to include what tells something of the reference path.
    """
    found = list[tuple[int, MomentMark]]()
    blocked = -2
    for step, moment in enumerate(moments):
        for mark in moment.marks:
            if mark in TRUTH_MARKS and not shows_truth:
                continue
            if mark is MomentMark.BLOCKED:
                was, blocked = blocked, step
                if was == step - 1:
                    continue
            found.append((step, mark))
    return found
