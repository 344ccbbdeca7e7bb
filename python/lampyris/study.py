"""Studies: a table of draws."""

from __future__ import annotations

import csv
import json
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass
class Study:
    """The draws of a study, and what they were made from."""

    record: dict
    """study.json: parameters, design, seed, program, files read."""
    draws: np.ndarray
    """Index of each row."""
    columns: dict[str, np.ndarray]
    """Parameters, then results, by name."""

    @property
    def parameters(self) -> list[str]:
        """Names of the columns that were drawn."""
        return sorted(self.record["parameters"])

    @property
    def results(self) -> list[str]:
        """Names of the columns that came out."""
        return [name for name in self.columns if name not in self.record["parameters"]]

    def to_pandas(self):
        """A pandas.DataFrame, by draw."""
        import pandas

        return pandas.DataFrame(self.columns, index=pandas.Index(self.draws, name="draw"))


def read_study(folder: str | os.PathLike) -> Study:
    """The study in a folder: its whole lines, if it still runs."""
    folder = Path(folder)
    record = json.loads((folder / "study.json").read_text(encoding="utf-8"))
    text = (folder / "draws.csv").read_text(encoding="utf-8")
    header, *rows = csv.reader(text[: text.rfind("\n") + 1].splitlines())
    table = np.array(rows, dtype=np.float64).reshape(len(rows), len(header))
    columns = {name: table[:, at] for at, name in enumerate(header) if at > 0}
    return Study(record, table[:, 0].astype(int), columns)
