"""Holds the README to its word.

    readme_blocks.py run README.md FOLDER
        runs every ```sql block with DuckDB and every ```python block in FOLDER, where `corpus` lies. A statement
        without a row, or a block that prints nothing, fails.
    readme_blocks.py printed README.md COMMAND OUTPUT
        compares the ```text block that begins with `$ COMMAND` with what the command printed, read from the file
        OUTPUT. Times, rates, sizes and the line of shares may differ, since they depend on the machine.

Exit 1 at the first difference.        (pip install duckdb polars pandas pyarrow)
"""

import contextlib
import io
import os
import re
import sys
from pathlib import Path


def blocks(readme, kind):
    """(line, text) of every fenced block of a kind."""
    text = Path(readme).read_text(encoding="utf-8")
    for found in re.finditer(rf"^```{kind}\n(.*?)^```$", text, re.M | re.S):
        yield text.count("\n", 0, found.start()) + 1, found[1]


def run(readme, folder):
    import duckdb

    queries, scripts = list(blocks(readme, "sql")), list(blocks(readme, "python"))
    if not queries or not scripts:
        sys.exit(f"{readme}: no queries or no scripts")
    os.chdir(folder)
    for line, text in queries:
        for statement in filter(str.strip, text.split(";")):
            rows = duckdb.sql(statement).fetchall()
            if not rows:
                sys.exit(f"{readme}:{line}: no row")
            print(f"{readme}:{line}: {len(rows)} rows, the first {rows[0]}")
    for line, text in scripts:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(text, f"{readme}:{line}", "exec"), {})
        if not printed.getvalue().strip():
            sys.exit(f"{readme}:{line}: prints nothing")
        print(f"{readme}:{line}: prints {len(printed.getvalue().splitlines())} lines")


def comparable(text):
    """The lines that two machines print alike."""
    lines = [line.rstrip() for line in text.strip().splitlines()]
    lines = [line for line in lines if not line.startswith(("$ ", "time ", "clips ", "cluster ", "enrich "))]
    measure = r"[\d.,]+ (s|ms|min|KB|kB|MB|GB|B|frames/s)\b"
    return [re.sub(r"\([\d.]+ of the text\)", "#", re.sub(measure, "#", line)) for line in lines]


def printed(readme, command, output):
    shown = [text for _, text in blocks(readme, "text") if text.splitlines()[0] == f"$ {command}"]
    if len(shown) != 1:
        sys.exit(f"{readme}: {len(shown)} blocks begin with `$ {command}`")
    want, got = comparable(shown[0]), comparable(Path(output).read_text(encoding="utf-8"))
    for number in range(max(len(want), len(got))):
        ours, theirs = (lines[number] if number < len(lines) else "(nothing)" for lines in (want, got))
        if ours != theirs:
            sys.exit(f"`{command}` no longer prints what {readme} shows\n  shown:   {ours}\n  printed: {theirs}")
    print(f"`{command}`: {len(got)} lines as shown")


if __name__ == "__main__":
    {"run": run, "printed": printed}[sys.argv[1]](*sys.argv[2:])
