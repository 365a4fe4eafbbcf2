"""The sub-command `library`: what there is under which name, with parameters, units and sources."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import click
from rich import box
from rich.console import Console
from rich.table import Table

from railvib import library as shelves
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import unit_of
from railvib.parameters.vehicle import Train, Vehicle


@click.command()
@click.argument("kind", type=click.Choice(shelves.KINDS), required=False)
@click.argument("name", required=False)
def library(kind: shelves.Kind | None, name: str | None) -> None:
    """Show what the library holds: all of it, one KIND of thing, or one NAME with parameters and sources."""
    console = Console()
    if kind is None:
        for each in shelves.KINDS:
            console.print(_shelf(each))
    elif name is None:
        console.print(_shelf(kind, sources=True))
    else:
        entry = shelves.entry(kind, name)
        console.print(f"[bold]{kind} {name}[/]: {entry.title}", highlight=False)
        console.print(f"Source: {entry.source}", highlight=False, markup=False)
        console.print(_facts(entry), highlight=False, markup=False)
        console.print(_parameters(entry))


def _shelf(kind: shelves.Kind, *, sources: bool = False) -> Table:
    table = Table(title=kind, title_justify="left", box=box.SIMPLE_HEAD)
    table.add_column("name", no_wrap=True)
    table.add_column("what it is")
    if sources:
        table.add_column("source")
    for name in shelves.names(kind):
        entry = shelves.entry(kind, name)
        table.add_row(name, entry.title, *([entry.source] if sources else []))
    return table


def _parameters(entry: shelves.Entry) -> Table:
    own_sources = bool(entry.sources)
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("parameter", no_wrap=True)
    table.add_column("value", justify="right")
    table.add_column("unit", no_wrap=True)
    if own_sources:
        table.add_column("source, where it is its own")
    for key, value in entry.parameters.items():
        note = entry.sources.get(key, "")
        for place, leaf, number in _leaves(key, value):
            table.add_row(place, _printed(number), unit_of(leaf), *([note] if own_sources else []))
            note = ""  # once for all parameters below a key
    return table


def _facts(entry: shelves.Entry) -> str:
    """Return what follows from the parameters and a reader would want beside them."""
    thing = shelves.load(entry.kind, entry.name)
    match thing:
        case Train():
            return f"Length {thing.length:g} m, {thing.axle_count} axles; vehicles from the head to the tail"
        case Vehicle():
            return f"Mass {thing.total_mass:,g} kg"
        case Unevenness():
            shortest, longest = thing.validity
            density = float(thing.psd(2.0 * math.pi / 10.0))
            return (
                f"Stated for wavelengths from {shortest:g} to {longest:g} m; "
                f"one-sided PSD {density:.3e} m²/(rad/m) at 10 m"
            )
        case _:
            return "Parameters per metre of track" if entry.kind == "track" else "From the surface down"


def _leaves(key: str, value: Any, place: str = "") -> Iterator[tuple[str, str, Any]]:
    """Yield the place, the key and the value of each single parameter below a key."""
    place = place or key
    if isinstance(value, Mapping):
        for inner, below in value.items():
            yield from _leaves(inner, below, f"{place}.{inner}")
    elif isinstance(value, Sequence) and not isinstance(value, str):
        for index, below in enumerate(value):
            yield from _leaves(key, below, f"{place}[{index}]")
    else:
        yield place, key, value


def _printed(value: Any) -> str:
    return f"{value:,.10g}" if isinstance(value, float) else str(value)
