"""Answers from the results: comparisons, SQL, shipped questions, summaries and exports."""

from queries.answers.approaches import in_order, label, reference, requested_approaches
from queries.answers.cases import MANY_CASES, NamedCase, case_count, named_cases, varying
from queries.answers.comparison import Levels, Pair, pairs
from queries.answers.costs import cost_table, cost_table_of_runs
from queries.answers.errors import PLACES, error_table
from queries.answers.export import export
from queries.answers.provenance import tables as provenance_tables
from queries.answers.questions import Question, question, questions
from queries.answers.sql import Limits, answer, query
from queries.answers.summary import extrapolation_notes, missing_notes, summary, verdicts
from queries.answers.table import Table, band, plain

__all__ = [
    "MANY_CASES",
    "PLACES",
    "Levels",
    "Limits",
    "NamedCase",
    "Pair",
    "Question",
    "Table",
    "answer",
    "band",
    "case_count",
    "cost_table",
    "cost_table_of_runs",
    "error_table",
    "export",
    "extrapolation_notes",
    "in_order",
    "label",
    "missing_notes",
    "named_cases",
    "pairs",
    "plain",
    "provenance_tables",
    "query",
    "question",
    "questions",
    "reference",
    "requested_approaches",
    "summary",
    "varying",
    "verdicts",
]
