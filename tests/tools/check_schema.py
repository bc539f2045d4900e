"""Checks a JSON file against a schema: python3 check_schema.py SCHEMA FILE. Properties that the schema does not name are refused, so
that it stays complete."""
import json
import pathlib
import sys

import jsonschema


def closed(schema):
    """The schema with no further properties in each of its objects."""
    if isinstance(schema, dict):
        schema = {name: closed(part) for name, part in schema.items()}
        if schema.get("type") == "object":
            schema.setdefault("additionalProperties", False)
    return [closed(part) for part in schema] if isinstance(schema, list) else schema


def read(file):
    return closed(json.loads(pathlib.Path(file).read_text()))


schema = pathlib.Path(sys.argv[1]).resolve()
resolver = jsonschema.RefResolver(schema.as_uri(), read(schema), handlers={"file": lambda uri: read(uri.removeprefix("file://"))})
jsonschema.Draft202012Validator(read(schema), resolver=resolver).validate(json.loads(pathlib.Path(sys.argv[2]).read_text()))
