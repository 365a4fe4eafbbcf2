"""The sub-command `library`: prints the entries of the library with parameters, units and sources."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import click
from rich import box
from rich.console import Console
from rich.table import Table

from railvib.library import catalogue, load
from railvib.library.catalogue import Entry, Kind
from railvib.parameters.composite_vehicle import CompositeVehicle
from railvib.parameters.unevenness import Unevenness
from railvib.parameters.units import unit_of
from railvib.parameters.vehicle import Train, Vehicle


@click.command()
@click.argument("kind", type=click.Choice(catalogue.KINDS), required=False)
@click.argument("name", required=False)
def library(kind: Kind | None, name: str | None) -> None:
    """Show what the library holds: all of it, one KIND of thing, or one NAME with parameters and sources."""
    console = Console()
    if kind is None:
        for each_kind in catalogue.KINDS:
            console.print(_contents(each_kind))
    elif name is None:
        console.print(_contents(kind, sources=True))
    else:
        entry = catalogue.entry(kind, name)
        console.print(f"[bold]{kind} {name}[/]: {entry.title}", highlight=False)
        console.print(f"Source: {entry.source}", highlight=False, markup=False)
        console.print(_summary(entry), highlight=False, markup=False)
        console.print(_parameters(entry))


def _contents(kind: Kind, *, sources: bool = False) -> Table:
    """Return a table of all entries of a kind."""
    table = Table(title=kind, title_justify="left", box=box.SIMPLE_HEAD)
    table.add_column("name", no_wrap=True)
    table.add_column("what it is")
    if sources:
        table.add_column("source")
    for name in catalogue.names(kind):
        entry = catalogue.entry(kind, name)
        table.add_row(name, entry.title, *([entry.source] if sources else []))
    return table


def _parameters(entry: Entry) -> Table:
    """Return a table of an entry's parameters; a source stands once for all values below its key."""
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("parameter", no_wrap=True)
    table.add_column("value", justify="right")
    table.add_column("unit", no_wrap=True)
    if entry.sources:
        table.add_column("source, where it is its own")
    for key, value in entry.parameters.items():
        source = entry.sources.get(key, "")
        for path, leaf_key, leaf in _leaves(key, value):
            text = f"{leaf:,.10g}" if isinstance(leaf, float) else str(leaf)
            table.add_row(path, text, unit_of(leaf_key), *([source] if entry.sources else []))
            source = ""
    return table


def _summary(entry: Entry) -> str:
    """Return what follows from the parameters and a reader would want beside them."""
    match load(entry.kind, entry.name):
        case Train() as train:
            return f"Length {train.length:g} m, {train.axle_count} axles; vehicles from the head to the tail"
        case Vehicle() | CompositeVehicle() as vehicle:
            return f"Mass {vehicle.total_mass:,g} kg"
        case Unevenness() as unevenness:
            shortest, longest = unevenness.validity
            density = float(unevenness.psd(2.0 * math.pi / 10.0))
            return (
                f"Stated for wavelengths from {shortest:g} to {longest:g} m; "
                f"one-sided PSD {density:.3e} m²/(rad/m) at 10 m"
            )
        case _:
            return "Parameters per metre of track" if entry.kind == "track" else "From the surface down"


def _leaves(key: str, value: Any, path: str = "") -> Iterator[tuple[str, str, Any]]:
    """Yield the path, the key and the value of every single parameter below a key."""
    path = path or key
    if isinstance(value, Mapping):
        for inner_key, item in value.items():
            yield from _leaves(inner_key, item, f"{path}.{inner_key}")
    elif isinstance(value, Sequence) and not isinstance(value, str):
        for index, item in enumerate(value):
            yield from _leaves(key, item, f"{path}[{index}]")
    else:
        yield path, key, value
