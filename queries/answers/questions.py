"""Named questions about results: SQL files with a sentence that says what they answer.

A file begins with comments: the sentence first, then a line per parameter with its name, its default value
and its meaning, as in `-- $level_db = 80.0: level that is exceeded, dB`.
"""

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from itertools import takewhile
from pathlib import Path
from typing import Any

from queries.database import ResultsError

_PARAMETER = re.compile(r"-- \$(?P<name>\w+) = (?P<value>.+?): (?P<meaning>.+)")


@dataclass(frozen=True)
class Parameter:
    """A parameter of a question."""

    default: str | float
    meaning: str

    def value(self, text: str) -> str | float:
        """Return a value given as text in the type of the default.

        Raises
        ------
        ValueError
            If a number is expected, and it is none.
        """
        return text if isinstance(self.default, str) else float(text)


@dataclass(frozen=True)
class Question:
    """A question with its name, the sentence that says what it answers, its parameters and its SQL."""

    name: str
    sentence: str
    parameters: Mapping[str, Parameter]
    sql: str

    def values(self, texts: Mapping[str, str]) -> dict[str, Any]:
        """Return the value of each parameter.

        Raises
        ------
        ResultsError
            If a parameter is given that the question does not have, or a value that is no number where one is
            expected.
        """
        for name in texts:
            if name not in self.parameters:
                known = ", ".join(self.parameters) or "none"
                raise ResultsError(f"{name}: {self.name} has no such parameter; it has: {known}")
        values: dict[str, Any] = {}
        for name, parameter in self.parameters.items():
            try:
                values[name] = parameter.value(texts[name]) if name in texts else parameter.default
            except ValueError:
                raise ResultsError(
                    f"{name} = {texts[name]}: must be a number ({parameter.meaning})"
                ) from None
        return values


def questions(folder: Path | None = None) -> dict[str, Question]:
    """Return the questions of railvib and those of a folder, which take precedence, by name.

    Raises
    ------
    ResultsError
        If the folder is missing, or a file in it does not begin with a sentence.
    """
    if folder is not None and not folder.is_dir():
        raise ResultsError(f"{folder}: no such folder of questions")
    shipped = resources.files("queries.answers") / "questions"
    files = [*shipped.iterdir(), *(folder.iterdir() if folder else ())]
    names = [(file.name.removesuffix(".sql"), file) for file in files if file.name.endswith(".sql")]
    return {
        name: _parse(name, file.read_text("utf-8"))
        for name, file in sorted(names, key=lambda named: named[0])
    }


def question(name: str, folder: Path | None = None) -> Question:
    """Return one question.

    Raises
    ------
    ResultsError
        If there is none of this name.
    """
    known = questions(folder)
    if name not in known:
        raise ResultsError(f"{name}: no such question; there are {', '.join(known)}")
    return known[name]


def _parse(name: str, text: str) -> Question:
    lines = text.splitlines()
    comments = list(takewhile(lambda line: line.startswith("--"), lines))
    matches = [(line, _PARAMETER.fullmatch(line.strip())) for line in comments]
    sentence = " ".join(line.removeprefix("--").strip() for line, match in matches if match is None).strip()
    if not sentence:
        raise ResultsError(f"{name}.sql: must begin with a comment that says what it answers")
    parameters = {}
    for line, match in matches:
        if match:
            try:
                default = ast.literal_eval(match["value"])
            except (ValueError, SyntaxError):
                default = None
            if isinstance(default, bool) or not isinstance(default, str | int | float):
                raise ResultsError(f"{name}.sql: the value in '{line}' must be a number or a 'text'")
            parameters[match["name"]] = Parameter(default, match["meaning"])
    return Question(name, sentence, parameters, "\n".join(lines[len(comments) :]).strip())
