"""The report of a run: one page that needs no network."""

from queries.report.write import shown_snapshot, write_report

__all__ = ["shown_snapshot", "write_report"]
