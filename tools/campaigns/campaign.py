"""What the campaigns share: the program, command-line options, progress, and tables in Markdown.

A campaign tries the program many times and writes a table of how many were tried and what was lost. Interrupted, the same
command goes on: what was tried is kept in a journal of one JSON object a line in the campaign's folder."""
import argparse
import json
import os
import pathlib
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = ROOT / 'build/release/tools/cli/gaitslam'


def options(description, default_count, count_help):
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument('--count', type=int, default=default_count, help=f'{count_help} (default {default_count})')
    parser.add_argument('--out', type=pathlib.Path, required=True, help='folder of the campaign; the same folder goes on')
    parser.add_argument('--program', type=pathlib.Path, default=PROGRAM, help='gaitslam (default: the release build)')
    return parser


class Journal:
    """What was tried so far; each entry has a name. An unfinished last line, of a kill, is left out."""

    def __init__(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        self.file = folder / 'journal.jsonl'
        self.entries = {}
        whole = ''
        if self.file.exists():
            for line in self.file.read_text().splitlines(keepends=True):
                if line.endswith('\n'):
                    entry = json.loads(line)
                    self.entries[entry['name']] = entry
                    whole += line
            self.file.write_text(whole)

    def __contains__(self, name):
        return name in self.entries

    def add(self, name, **values):
        self.entries[name] = {'name': name, **values}
        with self.file.open('a') as out:
            out.write(json.dumps(self.entries[name]) + '\n')
            out.flush()
            os.fsync(out.fileno())


class Progress:
    """A line on a terminal: how many are done and when the rest will be."""

    def __init__(self, total):
        self.total, self.begin, self.here = total, time.monotonic(), 0

    def show(self, done):
        self.here += 1
        if sys.stderr.isatty():
            left_s = (time.monotonic() - self.begin) / self.here * (self.total - done)
            end = '\n' if done == self.total else ''
            print(f'\r{done} of {self.total}, {left_s / 60:.0f} min left   ', end=end, file=sys.stderr, flush=True)


def write_table(folder, columns, rows, closing):
    """Writes table.md to a temporary name and renames it; prints it too."""
    lines = ['| ' + ' | '.join(columns) + ' |', '|' + '---|' * len(columns)]
    lines += ['| ' + ' | '.join(str(value) for value in row) + ' |' for row in rows]
    text = '\n'.join(lines) + '\n\n' + closing + '\n'
    temporary = folder / 'table.md.tmp'
    temporary.write_text(text)
    temporary.rename(folder / 'table.md')
    print(text)
