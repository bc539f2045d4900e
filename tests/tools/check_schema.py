"""Checks a JSON file against a schema: python3 check_schema.py SCHEMA FILE. Of JSON Schema it knows what the schemas of
results use, and refuses any other word. Properties that the schema does not name are refused, so that it stays complete."""
import json
import os
import sys

TYPES = {'object': dict, 'array': list, 'string': str, 'boolean': bool, 'null': type(None), 'integer': int,
         'number': (int, float)}
KNOWN = {'$schema', 'title', 'description', 'type', 'required', 'properties', 'additionalProperties', 'items', 'const',
         'enum', 'minimum', 'maximum', '$ref', '$defs'}


def is_of(value, name):
    return isinstance(value, TYPES[name]) and (name == 'boolean' or not isinstance(value, bool))


def check(value, schema, root, path):
    assert set(schema) <= KNOWN, f'{path}: the schema says {set(schema) - KNOWN}'
    if schema.get('$ref', '').endswith('.json'):
        other = json.load(open(os.path.join(os.path.dirname(sys.argv[1]), schema['$ref'])))
        return check(value, other, other, path)
    if '$ref' in schema:
        return check(value, root['$defs'][schema['$ref'].rsplit('/', 1)[1]], root, path)
    names = schema.get('type', [])
    names = names if isinstance(names, list) else [names]
    assert not names or any(is_of(value, name) for name in names), f'{path}: is {value!r}, expected {names}'
    for word, holds in (('const', lambda to: value == to), ('enum', lambda to: value in to),
                        ('minimum', lambda to: value is None or value >= to),
                        ('maximum', lambda to: value is None or value <= to)):
        assert word not in schema or holds(schema[word]), f'{path}: is {value}'
    if isinstance(value, dict):
        for name in schema.get('required', []):
            assert name in value, f'{path}.{name}: is missing'
        for name, entry in value.items():
            below = schema.get('properties', {}).get(name, schema.get('additionalProperties'))
            assert below is not None, f'{path}.{name}: the schema does not know it'
            check(entry, below, root, f'{path}.{name}')
    if isinstance(value, list):
        for i, entry in enumerate(value):
            check(entry, schema.get('items', {}), root, f'{path}[{i}]')


schema = json.load(open(sys.argv[1]))
check(json.load(open(sys.argv[2])), schema, schema, sys.argv[2])
