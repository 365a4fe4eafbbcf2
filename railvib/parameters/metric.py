"""The metrics of a passage: what engineers read from its history, by name.

| metric | signal | value | unit |
|---|---|---|---|
| ``kb-f-max`` | KB, 1 to 80 Hz | largest Fast running rms (DIN 4150-2) | 1 |
| ``v-max-fast``, ``v-max-slow`` | velocity in the bands that are predicted | largest running rms | m/s |
| ``ppv`` | velocity in the bands that are predicted | largest absolute value | m/s |
| ``vdv`` | Wb-weighted acceleration | (∫ a⁴ dt)^¼ (BS 6472-1) | m/s^1.75 |
| ``third-octave-max-fast`` | each one-third octave, filtered | largest Fast running rms | m/s |
"""

from typing import Literal, get_args

Metric = Literal["kb-f-max", "v-max-fast", "v-max-slow", "ppv", "vdv", "third-octave-max-fast"]
METRICS: tuple[Metric, ...] = get_args(Metric)

FEWEST_PASSAGES, MOST_PASSAGES = 16, 65_536
"""Range of the number of sampled passages, where it is not 0 for closed forms."""
