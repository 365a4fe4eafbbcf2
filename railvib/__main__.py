"""Runs the program: ``python -m railvib``."""

from railvib.cli import main

main(prog_name="railvib")
