"""The MCP server: its tools, and how their results and errors are sent."""

import base64
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from mcp import types
from mcp.server.lowlevel import Server
from mcp.shared.exceptions import MCPError
from pydantic import BaseModel

from arramon_client.errors import ArramonClientError, StepSpentError
from arramon_client.mcp import arguments, views
from arramon_client.mcp.tools import ToolResult, Tools
from arramon_client.printable import many_lines, to_json_line
from arramon_client.world import Action

NAME = "arramon"

INSTRUCTIONS = """\
ArraMon: follow instructions through the streets of a city, pick up an object, and place it in a room. An episode has
two turns, each with two phases. Navigation: walk as the instruction says, and pick up the object that it names.
Assembly: in a room of 5 columns and 4 rows, place that object where the instruction says. Each phase has a step limit
(`steps_left`).
Actions: FORWARD goes 1 m ahead, unless something solid is in the way; in the room one cell of 1.5 m, only at a heading
that is a multiple of 90 degrees. LEFT and RIGHT turn by 30 degrees. INTERACT picks up the nearest object, up to 3 m
straight ahead; in the room it puts the object in the cell ahead, for good. The camera's view is 60 degrees wide.
To play, `start` a run, or find an open one by `runs`; `look` at it; `act` on what you see with the `step` of that
observation, and so on with each result, until the run is over; then `report`. Ids of runs and episodes stay valid in
later sessions. A step is recorded before it is answered, and only once: if an answer is lost, repeat the call. With
clocks, `seconds_left` is what remains until the episode times out."""


@dataclass(frozen=True)
class _ToolSpec:
    """How a tool is described to a model, and what its arguments and results are."""

    title: str
    description: str
    arguments: type[arguments.Arguments]
    result: type[BaseModel]
    annotations: types.ToolAnnotations

    def described(self, name: str) -> types.Tool:
        return types.Tool(
            name=name,
            title=self.title,
            description=self.description,
            input_schema=self.arguments.model_json_schema(),
            output_schema=self.result.model_json_schema(),
            annotations=self.annotations,
        )


def _hints(*, read_only: bool = False, destructive: bool = False, idempotent: bool = False) -> types.ToolAnnotations:
    return types.ToolAnnotations(
        read_only_hint=read_only, destructive_hint=destructive, idempotent_hint=idempotent, open_world_hint=False
    )


TOOLS = {
    "start": _ToolSpec(
        "Start a run",
        "Create a run on a split in one language, and return its id. Calling it again creates another run: if an "
        "answer was lost, look for the run with `runs`.",
        arguments.StartArguments, views.PlayView, _hints(),
    ),
    "runs": _ToolSpec(
        "List runs",
        "List your runs, open and ended, with their limits and what is left of them.",
        arguments.RunsArguments, views.RunsView, _hints(read_only=True, idempotent=True),
    ),
    "look": _ToolSpec(
        "Look",
        "Show the instruction and the observation that await your next action, with images. Takes no step. An open run "
        "of an earlier session is resumed.",
        arguments.LookArguments, views.PlayView, _hints(read_only=True, idempotent=True),
    ),
    "act": _ToolSpec(
        "Act",
        "Take one step or several, and return the next observation. `step` is that of the latest observation. A plan "
        "of several actions stops when something unexpected happens (`stopped`): the way is blocked, nothing was "
        "picked up, the phase or the episode is over. Repeating a call takes no step twice; other actions at a step "
        "that was taken are an error, which names the present step.",
        arguments.ActArguments, views.ActView, _hints(idempotent=True),
    ),
    "give_up": _ToolSpec(
        "Give up an episode",
        "Give up an episode for good; it is scored as far as it was played.",
        arguments.GiveUpArguments, views.PlayView, _hints(destructive=True, idempotent=True),
    ),
    "report": _ToolSpec(
        "Report",
        "Show the scores of a run that is over, and the digest of its signed receipt.",
        arguments.ReportArguments, views.ReportView, _hints(read_only=True, idempotent=True),
    ),
}  # fmt: skip
"""Specifications of the tools, by name; `Tools` has a method of each name."""


def make_server(tools: Tools) -> Server[Any]:
    """Return the server; it holds no state of its own."""

    async def list_tools(_: Any, __: types.PaginatedRequestParams | None) -> types.ListToolsResult:
        return types.ListToolsResult(tools=[tool.described(name) for name, tool in TOOLS.items()])

    async def call_tool(_: Any, params: types.CallToolRequestParams) -> types.CallToolResult:
        tool = TOOLS.get(params.name)
        if tool is None:
            expected = ", ".join(TOOLS)
            raise MCPError(types.INVALID_PARAMS, f"unknown tool {params.name[:100]!r}, expected one of {expected}")
        method: Callable[[Any], Awaitable[ToolResult]] = getattr(tools, params.name)
        try:
            return _sent(await method(arguments.checked(tool.arguments, params.arguments or {})))
        except ArramonClientError as error:
            text = types.TextContent(type="text", text=many_lines(_in_words(error)))
            return types.CallToolResult(content=[text], is_error=True)

    return Server(
        NAME,
        version=version("arramon-client"),
        title="ArraMon",
        instructions=INSTRUCTIONS,
        on_list_tools=list_tools,
        on_call_tool=call_tool,
    )


def _in_words(error: ArramonClientError) -> str:
    """Return an error's message, with the name of a recorded action."""
    if isinstance(error, StepSpentError) and error.recorded is not None:
        now = "the episode has ended" if error.present is None else f"the present step is {error.present}"
        was = f"step {error.step} of episode {error.episode_id} was answered with {Action(error.recorded).name}"
        return f"{was}, which remains recorded; {now}"
    return str(error)


def _sent(result: ToolResult) -> types.CallToolResult:
    """Return a result: as JSON text, with its images, and as structured content."""
    data = result.data.model_dump(mode="json", exclude_none=True)
    content: list[types.ContentBlock] = [types.TextContent(type="text", text=to_json_line(data).rstrip())]
    for picture in result.pictures:
        encoded = base64.b64encode(picture.content).decode("ascii")
        content.append(types.ImageContent(type="image", data=encoded, mime_type=picture.mime_type))
    return types.CallToolResult(content=content, structured_content=data)
