"""Opens every table of a corpus folder with DuckDB, Polars and pandas (pyarrow), reads all of it with each, and
compares rows, columns and the number of values that aren't null in every column. Exit 1 at the first difference.

    python3 tests/peers/open_tables.py CORPUS        (pip install duckdb polars pyarrow pandas)
"""

import sys
from pathlib import Path

import duckdb
import pandas
import polars
import pyarrow.parquet


def datasets(corpus):
    """Name -> files: a table over the corpus is one file, a sharded one all files of a folder."""
    found = {}
    for file in sorted(corpus.rglob("*.parquet")):
        name = file.relative_to(corpus)
        key = str(name) if len(name.parts) == 1 else str(name.parent)
        # The items of each plant state are a file of their own in one folder: one table all the same.
        found.setdefault(key, []).append(str(file))
    return found


def with_duckdb(files):
    table = duckdb.connect().read_parquet(files, hive_partitioning=False)
    columns = table.columns
    quoted = ['"' + column.replace('"', '""') + '"' for column in columns]
    counts = table.aggregate("count(*), " + ", ".join(f"count({column})" for column in quoted)).fetchall()[0]
    return counts[0], dict(zip(columns, counts[1:]))


def with_polars(files):
    table = polars.read_parquet(files, hive_partitioning=False)
    return table.height, {column: table.height - table[column].null_count() for column in table.columns}


def with_pandas(files):
    table = pandas.concat([pandas.read_parquet(file, engine="pyarrow", partitioning=None) for file in files])
    return len(table), {column: int(table[column].notna().sum()) for column in table.columns}


def main(corpus):
    tables = datasets(corpus)
    if not tables:
        sys.exit(f"{corpus}: no tables")
    for name, files in tables.items():
        schema = pyarrow.parquet.read_schema(files[0])
        if schema.names != list(dict.fromkeys(schema.names)):
            sys.exit(f"{name}: a column name twice")
        if b"space" not in (schema.field(-1).metadata or {}) and name.split("/")[0] in ("channels", "poses", "features"):
            sys.exit(f"{name}: no space in the metadata of its last column")
        metadata = pyarrow.parquet.read_metadata(files[0]).metadata
        if metadata.get(b"motionmill.format_version") is None:
            sys.exit(f"{name}: no format version in the file metadata")
        answers = {"duckdb": with_duckdb(files), "polars": with_polars(files), "pandas": with_pandas(files)}
        rows = sum(pyarrow.parquet.read_metadata(file).num_rows for file in files)
        for reader, (found, counts) in answers.items():
            if found != rows or list(counts) != schema.names:
                sys.exit(f"{name}: {reader} reads {found} rows of {len(counts)} columns, written {rows} of {len(schema.names)}")
            if counts != answers["duckdb"][1]:
                sys.exit(f"{name}: {reader} and duckdb count other values")
        print(f"{name}: {len(files)} files, {rows} rows, {len(schema.names)} columns")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
