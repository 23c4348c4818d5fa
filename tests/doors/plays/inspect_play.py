"""Plays by `inspect_ai.eval` with its own mock model; the task is found by its registered name."""

from pathlib import Path

from inspect_ai import eval as evaluate
from inspect_ai.model import ModelOutput, ModelUsage, get_model
from script import ADDRESS, EPISODE, LANGUAGE, OUTPUT, plan, step_of, write


def answer(messages, tools, choice, config):
    """Call `look` first, and then `act`."""
    texts = [message.text for message in messages if "Step " in message.text]
    step = step_of(texts[-1])
    call = ("look", {}) if len(texts) == 1 else ("act", {"step": step, "actions": plan(step)})
    assert [tool.name for tool in tools] == ["look", "act"]
    assert any(part.type == "image" for part in messages[1].content)
    output = ModelOutput.for_tool_call("mockllm", *call)
    output.usage = ModelUsage(input_tokens=1, output_tokens=1, total_tokens=2)  # else it downloads a tokenizer
    return output


def evaluated(language: str, split: str, **more):
    """Return the samples of an evaluation."""
    (log,) = evaluate(
        "arramon_client/arramon",
        task_args={"lang": language, "split": split, "server": ADDRESS},
        model=get_model("mockllm/model", custom_outputs=answer),
        log_dir=str(Path(OUTPUT).parent / "logs"),
        display="none",
        **more,
    )
    assert log.status == "success", log.error
    return log.samples


(sample,) = evaluated(LANGUAGE, "tiny", sample_id=EPISODE)
score = sample.scores["episode_score"]
assert sample.metadata == {"section": "1"}
write({**score.metadata, "headline": score.value})

# A hidden split of two episodes: the sample that ends the run has its scores.
scores = [sample.scores["run_score"] for sample in evaluated("en", "secret")]
assert sorted(isinstance(score.value, dict) for score in scores) == [False, True]
assert len({score.metadata["run_id"] for score in scores}) == 1
