"""The page of the protocol, from the comments of its `.proto` files."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from google.protobuf import descriptor_pb2

from website.page import Page
from website.staging import ROOT

FILES = ("evaluation", "leaderboard", "types")

SERVICE, MESSAGE, ENUM = 6, 4, 5
"""Field numbers of a file's services, messages and enumerations (`descriptor.proto`)."""

METHOD, FIELD, NESTED, NESTED_ENUM, VALUE = 2, 2, 3, 4, 2
"""Field numbers of a service's methods; a message's fields, messages and enumerations; an enumeration's values."""

Descriptor = descriptor_pb2.DescriptorProto
Type = descriptor_pb2.FieldDescriptorProto


def pages() -> Sequence[Page]:
    """Return a page for each file of the protocol."""
    return [
        Page(f"reference/protocol/{name}.md", "Protocol", f"{name}.proto", _text(each))
        for name, each in zip(FILES, descriptors(), strict=True)
    ]


def descriptors() -> Sequence[descriptor_pb2.FileDescriptorProto]:
    """Return the protocol's files, parsed, with their comments."""
    import tempfile

    from grpc_tools import protoc

    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "set"
        sources = [f"arramon/v1/{name}.proto" for name in FILES]
        arguments = ["protoc", f"--proto_path={ROOT / 'proto'}", "--include_source_info", f"--descriptor_set_out={out}"]
        if protoc.main([*arguments, *sources]):
            raise ValueError("the protocol's files could not be parsed")
        files = descriptor_pb2.FileDescriptorSet.FromString(out.read_bytes()).file
    by_name = {each.name: each for each in files}
    return [by_name[source] for source in sources]


class _File:
    """A file of the protocol, as Markdown."""

    def __init__(self, file: descriptor_pb2.FileDescriptorProto) -> None:
        self.file = file
        self._comments = {tuple(each.path): each for each in file.source_code_info.location}

    def lines(self) -> Iterator[str]:
        syntax = self._comments.get((12,))
        yield f"# {self.file.name.rpartition('/')[2]}\n"
        yield f"Package `{self.file.package}`. {self._flat(syntax.leading_comments if syntax else '')}\n"
        for number, service in enumerate(self.file.service):
            yield f"## Service {service.name}\n"
            yield from self._comment((SERVICE, number))
            for at, method in enumerate(service.method):
                request = ("stream " if method.client_streaming else "") + _last(method.input_type)
                response = ("stream " if method.server_streaming else "") + _last(method.output_type)
                yield f"### {method.name}\n\n`{method.name}({request}) returns ({response})`\n"
                yield from self._comment((SERVICE, number, METHOD, at))
        for number, message in enumerate(self.file.message_type):
            yield from self._message(message, (MESSAGE, number), message.name)
        for number, enum in enumerate(self.file.enum_type):
            yield from self._enum(enum, (ENUM, number), enum.name)

    def _enum(self, enum: descriptor_pb2.EnumDescriptorProto, path: tuple[int, ...], name: str) -> Iterator[str]:
        yield f"## {name}\n"
        yield from self._comment(path)
        yield "| value | number | meaning |\n| --- | --- | --- |"
        for at, value in enumerate(enum.value):
            yield f"| `{value.name}` | {value.number} | {self._cell((*path, VALUE, at))} |"
        yield ""

    def _message(self, message: Descriptor, path: tuple[int, ...], name: str) -> Iterator[str]:
        yield f"## {name}\n"
        yield from self._comment(path)
        entries = {
            f".{self.file.package}.{name}.{each.name}": each for each in message.nested_type if each.options.map_entry
        }
        if message.field:
            yield "| field | type | meaning |\n| --- | --- | --- |"
        for at, field in enumerate(message.field):
            group = ""
            if field.HasField("oneof_index") and not field.proto3_optional:
                group = f"*one of `{message.oneof_decl[field.oneof_index].name}`.* "
            kind = _type(field, entries)
            yield f"| `{field.name}` = {field.number} | {kind} | {group}{self._cell((*path, FIELD, at))} |"
        yield ""
        for at, nested in enumerate(message.nested_type):
            if not nested.options.map_entry:
                yield from self._message(nested, (*path, NESTED, at), f"{name}.{nested.name}")
        for at, enum in enumerate(message.enum_type):
            yield from self._enum(enum, (*path, NESTED_ENUM, at), f"{name}.{enum.name}")

    def _comment(self, path: tuple[int, ...]) -> Iterator[str]:
        if text := self._text(path):
            yield f"{text}\n"

    def _cell(self, path: tuple[int, ...]) -> str:
        return self._text(path).replace("|", "\\|").replace("\n", " ")

    def _text(self, path: tuple[int, ...]) -> str:
        found = self._comments.get(path)
        return self._flat(f"{found.leading_comments}\n{found.trailing_comments}") if found else ""

    @staticmethod
    def _flat(text: str) -> str:
        paragraphs = "\n".join(line.strip() for line in text.strip().split("\n")).split("\n\n")
        return "\n\n".join(" ".join(part.split()) for part in paragraphs).replace("<", "&lt;").replace("*", "\\*")


def _text(file: descriptor_pb2.FileDescriptorProto) -> str:
    return "\n".join(_File(file).lines())


def _type(field: Type, entries: dict[str, Descriptor]) -> str:
    """Return a field's type as the language writes it."""
    if field.type_name in entries:
        key, value = entries[field.type_name].field
        return f"`map<{_type(key, {}).strip('`')}, {_type(value, {}).strip('`')}>`"
    name = _last(field.type_name) or Type.Type.Name(field.type).removeprefix("TYPE_").lower()
    before = "optional " if field.proto3_optional else "repeated " if field.label == Type.LABEL_REPEATED else ""
    return f"`{before}{name}`"


def _last(name: str) -> str:
    return name.removeprefix(".arramon.v1.")
