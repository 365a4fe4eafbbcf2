"""The computation as a graph of stages: one file per stage, evaluated in memory or run by an engine."""

from railvib.stages.graph import STAGES, case_spectra, evaluate, stage_of
from railvib.stages.stage import Load, Scope, Stage, Work
from railvib.stages.warm_up import warm_up

__all__ = ["STAGES", "Load", "Scope", "Stage", "Work", "case_spectra", "evaluate", "stage_of", "warm_up"]
