"""Clocks of a stream, with a clock that only the test moves."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arramon_server.runs.play.clocks import STALL_SECONDS, Bank, ClockSettings, PlayClock, StreamClock, TimeLeft


class Time:
    """Clock that the test moves."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


class Desk:
    """A stream's clock, and the operations of a test on it."""

    def __init__(self, bank: float) -> None:
        self.time = Time()
        self.bank = Bank(bank)
        self.clock = StreamClock(60.0, self.bank, self.time)

    def show(self, *observations: tuple[str, int]) -> None:
        """Send observations."""
        self.clock.send(observations)

    def answer(self, episode_id: str, step: int) -> None:
        self.clock.charge(self.time.now)
        self.clock.answer(episode_id, step)

    def out_after(self, seconds: float) -> list[str]:
        self.time.now += seconds
        self.clock.charge(self.time.now)
        return self.clock.out_of_time(self.time.now)


def desk_with(*episodes: str, bank: float = 100.0) -> Desk:
    desk = Desk(bank=bank)
    for episode in episodes:
        desk.clock.open(episode, 0)
    return desk


def test_an_answer_within_its_time_costs_nothing() -> None:
    desk = desk_with("a")
    desk.show(("a", 0))
    desk.time.now += 60.0
    desk.answer("a", 0)
    assert desk.bank.left == 100.0
    assert desk.clock.take_charges() == 0.0


def test_overdue_time_is_charged_to_the_bank() -> None:
    desk = desk_with("a")
    desk.show(("a", 0))
    desk.time.now += 75.0
    desk.answer("a", 0)
    assert desk.bank.left == 85.0
    assert desk.clock.take_charges() == 15.0
    assert desk.clock.take_charges() == 0.0  # it is to be written once


def test_an_overdue_step_is_out_of_time_when_the_bank_is_empty() -> None:
    desk = desk_with("a")
    desk.show(("a", 0))
    assert desk.out_after(159.0) == []
    assert desk.bank.left == 1.0
    assert desk.out_after(1.5) == ["a"]
    assert desk.bank.left == 0.0


def test_without_a_bank_only_the_step_time_is_available() -> None:
    desk = desk_with("a", bank=0.0)
    desk.show(("a", 0))
    assert desk.out_after(60.0) == []
    assert desk.out_after(0.01) == ["a"]


def test_overdue_time_of_many_episodes_counts_once() -> None:
    desk = desk_with("a", "b", "c")
    desk.show(("a", 0), ("b", 0))
    desk.time.now += 10.0
    desk.show(("c", 0))
    desk.time.now += 60.0  # a and b are 10 late, c not at all
    desk.answer("a", 0)
    desk.time.now += 5.0
    desk.answer("b", 0)
    desk.answer("c", 0)
    assert desk.bank.left == 100.0 - 15.0


def test_two_streams_of_a_run_share_its_bank() -> None:
    desk = desk_with("a")
    other = StreamClock(60.0, desk.bank, desk.time)
    other.open("b", 0)
    desk.show(("a", 0))
    other.send([("b", 0)])
    desk.time.now += 70.0
    desk.answer("a", 0)
    other.charge(desk.time.now)
    assert desk.bank.left == 80.0


def test_with_an_empty_bank_punctual_episodes_continue() -> None:
    desk = desk_with("slow", "quick", bank=5.0)
    desk.show(("slow", 0), ("quick", 0))
    desk.time.now += 50.0
    desk.answer("quick", 0)
    desk.show(("quick", 1))
    assert desk.out_after(20.0) == ["slow"]
    desk.clock.close("slow")
    for step in range(1, 4):
        assert desk.out_after(39.0) == []
        desk.answer("quick", step)
        desk.show(("quick", step + 1))
    assert desk.bank.left == 0.0


def test_the_time_begins_when_the_observation_is_sent() -> None:
    desk = desk_with("a")
    desk.time.now += 59.0  # the server draws
    assert desk.clock.time_left("a") == TimeLeft(60.0, 100.0)
    desk.show(("a", 0))
    desk.time.now += 60.0
    desk.answer("a", 0)
    assert desk.bank.left == 100.0


def test_the_time_of_what_is_not_read_begins_when_it_could_be_read() -> None:
    desk = desk_with("a", "b", bank=0.0)
    desk.show(("a", 0))
    desk.time.now += 50.0
    desk.clock.begin_all()
    desk.time.now += 5.0
    desk.clock.begin_all()
    desk.show(("b", 0))
    assert desk.out_after(6.0) == ["a"]
    desk.clock.close("a")
    assert desk.out_after(49.0) == []
    assert desk.out_after(0.1) == ["b"]


def test_resent_observation_does_not_restart_the_step_time() -> None:
    desk = desk_with("a")
    desk.show(("a", 0))
    desk.time.now += 50.0
    desk.show(("a", 0))
    assert desk.clock.time_left("a") == TimeLeft(10.0, 100.0)


def test_an_observation_that_is_sent_after_its_action_begins_no_step() -> None:
    desk = desk_with("a")
    desk.answer("a", 0)
    desk.show(("a", 0))
    assert desk.out_after(1000.0) == []
    assert desk.bank.left == 100.0


def test_resumed_episode_keeps_its_elapsed_step_time() -> None:
    desk = desk_with("a", "b")
    desk.show(("a", 0))
    desk.time.now += 45.0
    assert desk.clock.waiting_times() == {"a": (0, 45.0), "b": (0, None)}
    other = StreamClock(60.0, desk.bank, desk.time)
    other.open("a", 0, 50.0)
    desk.time.now += 5.0  # its time runs on before it is sent again
    other.send([("a", 0)])
    assert other.time_left("a") == TimeLeft(5.0, 100.0)
    assert other.waiting_times() == {"a": (0, 55.0)}
    desk.time.now += 10.0
    other.charge(desk.time.now)
    assert desk.bank.left == 95.0


def test_previously_overdue_time_is_not_charged_again() -> None:
    desk = desk_with()
    desk.clock.open("a", 7, 80.0)
    desk.time.now += 10.0
    desk.answer("a", 7)
    assert desk.bank.left == 90.0
    assert desk.clock.waiting_times() == {"a": (8, None)}


def test_ended_episode_is_not_charged() -> None:
    desk = desk_with("a")
    desk.show(("a", 0))
    assert desk.out_after(70.0) == []
    desk.clock.close("a")
    assert desk.out_after(1000.0) == []
    assert desk.bank.left == 90.0


@given(st.lists(st.tuples(st.sampled_from("abc"), st.floats(0.0, 100.0)), max_size=30))
def test_charges_never_exceed_the_elapsed_time_or_the_bank(moves: list[tuple[str, float]]) -> None:
    desk = desk_with("a", "b", "c")
    steps = dict.fromkeys("abc", 0)
    desk.show(*steps.items())
    began = desk.time.now
    for episode, seconds in moves:
        desk.time.now += seconds
        desk.answer(episode, steps[episode])
        steps[episode] += 1
        desk.show((episode, steps[episode]))
    charged = desk.clock.take_charges()
    assert 0.0 <= charged <= max(0.0, desk.time.now - began - 60.0) + 1e-6
    assert desk.bank.left == pytest.approx(max(0.0, 100.0 - charged))


def test_stopwatch_excludes_stalls_of_the_server() -> None:
    time = Time()
    watch = PlayClock(time)
    began = watch()
    time.now += 1.0
    assert watch() - began == 1.0
    time.now += STALL_SECONDS + 50.0
    assert watch() - began == 1.0
    time.now += 2.0
    assert watch() - began == 3.0


@pytest.mark.parametrize(
    ("clocks", "text"),
    [
        (ClockSettings(), "none"),
        (ClockSettings(0.0, 3600.0), "none"),
        (ClockSettings(60.0, 86_400.0), "60/86400"),
        (ClockSettings(0.25, 0.0), "0.25/0"),
    ],
)
def test_clocks_are_formatted_for_signatures(clocks: ClockSettings, text: str) -> None:
    assert str(clocks) == text
    assert bool(clocks) is (text != "none")
