"""The sub-command `library` prints every entry, lists them, and refuses unknown ones."""

import pytest
from click.testing import CliRunner

from railvib import library
from railvib.cli import main

EVERYTHING = [(kind, name) for kind in library.KINDS for name in library.names(kind)]


@pytest.mark.parametrize(("kind", "name"), EVERYTHING)
def test_command_prints_every_entry(kind, name):
    result = CliRunner().invoke(main, ["library", kind, name])
    assert result.exit_code == 0, result.output
    entry = library.entry(kind, name)
    assert entry.source.split(",")[0] in " ".join(result.output.split())
    assert all(key in result.output for key in entry.parameters)


def test_command_lists():
    everything = CliRunner().invoke(main, ["library"]).output
    assert all(name in everything for _, name in EVERYTHING)
    soils = CliRunner().invoke(main, ["library", "soil"]).output
    assert "greby" in soils
    assert "regina" not in soils


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["library", "soil", "grebi"], "Error: soil = 'grebi': is unknown; the nearest known is 'greby'"),
        (["library", "rock"], "'rock' is not one of"),
    ],
)
def test_command_refuses_with_exit_code_2(arguments, message):
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 2
    assert message in result.stderr
