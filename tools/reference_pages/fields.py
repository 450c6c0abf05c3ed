"""Fields of our models as rows of tables, by the JSON schemas that ``mamo schema`` prints."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core.core_schema import WithDefaultSchema

from reference_pages.markdown import prose, table

COLUMNS = ("key", "type", "default", "meaning")
_TYPES = {"string": "text", "boolean": "true or false", "object": "mapping"}
_BOUNDS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}

Schema = dict[str, Any]
Definitions = Mapping[str, Schema]


class _WithFactories(GenerateJsonSchema):
    """Defaults that a function makes are defaults, too."""

    def get_default_value(self, schema: WithDefaultSchema) -> Any:
        factory: Any = schema.get("default_factory")
        return super().get_default_value(schema) if factory is None else factory()


def fields_table(model: type[BaseModel]) -> str:
    """The fields of a model; keys of nested models are dotted."""
    schema = model.model_json_schema(schema_generator=_WithFactories)
    return table(COLUMNS, _nested_rows(schema, schema.get("$defs", {})))


def sections(model: type[BaseModel]) -> str:
    """A heading and a table for a model, and for every model that it refers to."""
    schema = model.model_json_schema(schema_generator=_WithFactories)
    definitions = schema.get("$defs", {})
    models = {model.__name__: schema, **definitions}
    return "\n\n".join(
        f"### {name}\n\n{_words(part)}\n\n{table(COLUMNS, _rows(part, definitions))}"
        for name, part in models.items()
        if "properties" in part
    )


def _nested_rows(schema: Schema, definitions: Definitions, before: str = "") -> Iterator[list[str]]:
    for row, field in zip(_rows(schema, {}, before), schema["properties"].values(), strict=True):
        yield row
        for option in field.get("anyOf", [field]):
            if "$ref" in option:
                inner = definitions[_name(option)]
                yield from _nested_rows(inner, definitions, f"{row[0].strip('`')}.")


def _rows(schema: Schema, definitions: Definitions, before: str = "") -> Iterator[list[str]]:
    required = schema.get("required", [])
    for name, field in schema["properties"].items():
        default = "required" if name in required else f"`{json.dumps(field['default'])}`"
        yield [f"`{before}{name}`", _type(field, definitions), default, _words(field)]


def _words(schema: Schema) -> str:
    return prose(" ".join(schema.get("description", "").split()))


def _name(reference: Schema) -> str:
    return str(reference["$ref"].rpartition("/")[2])


def _type(field: Schema, definitions: Definitions) -> str:
    """In words; models among the ``definitions`` are links to their sections."""
    if "$ref" in field:
        return _reference(_name(field), definitions)
    if "anyOf" in field:
        return " or ".join(_type(option, definitions) for option in field["anyOf"])
    if "const" in field or "enum" in field:
        return ", ".join(f"`{value}`" for value in field.get("enum", [field.get("const")]))
    if field.get("type") == "array":
        return _array(field, definitions)
    return _number_or_text(field)


def _reference(name: str, definitions: Definitions) -> str:
    if name not in definitions:
        return "mapping"
    if "properties" in definitions[name]:
        return f"[{name}](#{name.lower()})"
    return _type(definitions[name], definitions)


def _array(field: Schema, definitions: Definitions) -> str:
    if "prefixItems" in field:
        return f"[{', '.join(_type(item, definitions) for item in field['prefixItems'])}]"
    least = f", at least {field['minItems']}" if "minItems" in field else ""
    return f"list of {_type(field['items'], definitions)}{least}"


def _number_or_text(field: Schema) -> str:
    kind = field["type"]
    bounds = [f"{sign} {field[word]:g}" for word, sign in _BOUNDS.items() if word in field]
    return f"{_TYPES.get(kind, kind)} {', '.join(bounds)}".rstrip()
