"""Levels of the passages of one case by one approach, at several receivers."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from railvib import cost
from railvib.forces.receptance import Receptances
from railvib.numerics import threads
from railvib.parameters.approach import Approach
from railvib.parameters.ground import Ground
from railvib.parameters.receiver import Receiver
from railvib.passage.amplitudes import Block, time_shift
from railvib.passage.closed_levels import closed_levels
from railvib.passage.excitation import moving_excitation, standing_excitation
from railvib.passage.full_model import full_model_amplitudes
from railvib.passage.grid import Grid, passage_grid
from railvib.passage.levels import Level, expectations, sampled_values, statistics
from railvib.passage.metrics import signals
from railvib.passage.moving_roughness import moving_roughness_amplitudes
from railvib.passage.quasi_static import quasi_static_amplitudes
from railvib.psd.spectra import Passage
from railvib.transfer.transfer_function import TransferFunction

LINES_AT_ONCE = 128
"""Lines of the full model's amplitudes that are computed together."""


class Request(NamedTuple):
    """Which levels are wanted."""

    metrics: tuple[str, ...]
    """Names of metrics, see `railvib.parameters.metric`."""
    quantiles: tuple[float, ...]
    """Over realisations of the unevenness, between 0 and 1."""
    passages: int
    """Number of sampled passages; 0 for closed forms."""
    seed: int
    """Seed of the ensemble, which all cases share."""


@dataclass(frozen=True)
class PassageLevels:
    """Statistics of metrics of passages at some receivers, a row each."""

    value: np.ndarray = field(
        metadata={"dims": ("row",), "unit": "see unit", "description": "value of the statistic"}
    )
    receiver: np.ndarray = field(metadata={"dims": ("row",), "unit": "", "description": "rail or ground"})
    offset_m: np.ndarray = field(
        metadata={"dims": ("row",), "unit": "m", "description": "distance from the centre line"}
    )
    metric: np.ndarray = field(metadata={"dims": ("row",), "unit": "", "description": "name of the metric"})
    statistic: np.ndarray = field(
        metadata={"dims": ("row",), "unit": "", "description": "mean, expected, or q and the quantile"}
    )
    unit: np.ndarray = field(metadata={"dims": ("row",), "unit": "", "description": "unit of the value"})
    approach: str


class RandomPassage:
    """The random passage of a case by an approach, at one receiver after the other.

    Parameters
    ----------
    approach
        The approach; moving roughness by axle is moving roughness.
    passage
        The train, the unevenness, the speed and the bands.
    ground
        The ground.
    rail
        The rail's receptances, moving for the full model and else standing.
    highest
        Highest frequency of excitation that counts, Hz, see `railvib.psd.spectra.highest_excitation`.
    """

    def __init__(
        self, approach: Approach, passage: Passage, ground: Ground, rail: Receptances, highest: float
    ) -> None:
        self.approach = approach
        self._passage = passage
        train, speed = passage.train, passage.speed
        self.grid: Grid = passage_grid(ground, train.length, speed, passage.band, highest)
        self._shift = time_shift(self.grid, train.length, speed)
        beta = self.grid.wavenumber
        with cost.stage("excitation"):
            if approach == "full":
                self._excitation = moving_excitation(train, rail, passage.unevenness, speed, beta)
            else:
                # Below and above the lines, where there are no receptances, nothing is excited.
                own = beta * speed / (2.0 * np.pi)
                lines = self.grid.frequency
                inside = np.flatnonzero((own >= lines[0]) & (own <= lines[-1]))
                uncorrelated = approach == "moving-roughness-uncorrelated"
                sets = standing_excitation(train, rail, passage.unevenness, speed, beta[inside], uncorrelated)
                self._excitation = np.zeros((sets.shape[0], beta.size, sets.shape[2]), complex)
                self._excitation[:, inside] = sets

    @property
    def band(self) -> np.ndarray:
        """One-third octaves that the histories hold, exact midbands, Hz."""
        return np.asarray(self._passage.band)

    def amplitudes(self, receiver: Receiver, function: TransferFunction) -> list[Block]:
        """Return the amplitudes of velocity at a receiver."""
        train, speed = self._passage.train, self._passage.speed
        with cost.stage("random passage") as spent:
            if self.approach == "full":
                blocks = full_model_amplitudes(
                    {receiver: function},
                    self._excitation,
                    train.axle_positions,
                    train.length,
                    speed,
                    self.grid,
                    LINES_AT_ONCE,
                )[receiver]
            else:
                position = train.axle_positions - 0.5 * train.length
                blocks = list(
                    moving_roughness_amplitudes(function, self._excitation, position, speed, self.grid)
                )
            spent.evaluations += sum(block.value.size for block in blocks)
        return blocks

    def mean(self, function: TransferFunction) -> np.ndarray:
        """Return the amplitudes of the quasi-static part at a receiver, complex (lines,), m/s."""
        train = self._passage.train
        position = train.axle_positions + self._shift
        return quasi_static_amplitudes(function, train.axle_loads, position, self._passage.speed, self.grid)


@threads.single()
def passage_levels(
    random: RandomPassage, receivers: Mapping[Receiver, TransferFunction], request: Request
) -> PassageLevels:
    """Return the levels of random passages at some receivers.

    Parameters
    ----------
    random
        The random passage of a case.
    receivers
        The receivers' transfer functions, taken one by one.
    request
        Which levels.
    """
    wanted = list(signals(request.metrics, random.grid.frequency, random.band))
    rows: list[tuple[Receiver, Level]] = []
    for receiver in receivers:
        function = receivers[receiver]
        amplitudes, mean = random.amplitudes(receiver, function), random.mean(function)
        with cost.stage("passage levels"):
            if request.passages:
                values = sampled_values(amplitudes, mean, random.grid, wanted, request.passages, request.seed)
                expected = expectations(amplitudes, mean, random.grid, wanted)
                levels = statistics(values, expected, request.quantiles)
            else:
                levels = closed_levels(amplitudes, mean, random.grid, wanted, request.quantiles)
            rows += [(receiver, level) for level in levels]
    return PassageLevels(
        value=np.array([level.value for _receiver, level in rows]),
        receiver=np.array([receiver.name for receiver, _level in rows]),
        offset_m=np.array([receiver.offset_m for receiver, _level in rows]),
        metric=np.array([level.metric for _receiver, level in rows]),
        statistic=np.array([level.statistic for _receiver, level in rows]),
        unit=np.array([level.unit for _receiver, level in rows]),
        approach=random.approach,
    )
