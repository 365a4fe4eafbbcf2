"""A small study of the real physics, and the program as a user calls it."""

from click.testing import CliRunner, Result

from railvib.cli import main

STUDY = """
[study]
name = "small"
[frequency]
minimum_hz = 4.0
maximum_hz = 8.0
[receivers]
offsets_m = [8]
[approaches]
compare = ["moving-roughness", "full"]
reference = "full"
[sweep]
soil = ["horstwalde"]
track = ["ballasted-paper"]
train = ["single"]
unevenness = ["german-low"]
speed_kmh = [30]
[accuracy]
tolerance = 1e-3
[train.single]
vehicle = "regina"
"""


def invoke(*arguments: object) -> Result:
    """Call the program in this process."""
    return CliRunner().invoke(main, [str(argument) for argument in arguments])
