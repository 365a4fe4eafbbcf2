"""Writes moving_load.csv and winkler_rail.csv from closed forms.

Run from the top of the repository: ``python -m tests.data.closed_forms``. Nothing of railvib is used.
"""

import math
from pathlib import Path

DATA = Path(__file__).parent
MOVING_LOAD_HEADER = """\
# Steady displacement per newton [m/N] beside a constant load moving on an elastic half-space. Source: closed
# form, see closed_forms.py; checked by quadrature.
shear_speed_m_s,poisson_ratio,density_kg_m3,offset_m,load_speed_m_s,displacement_m_n
"""
WINKLER_RAIL_HEADER = """\
# Direct receptance [m/N] of a rail on a two-layer support without ground. Source: closed form, see
# closed_forms.py; equal to rolland's EBBCont2L to 9 digits.
# One rail: EI = 6.3777e6 N m2, 60.2 kg/m, pad 3e8 + 3e4 i omega N/m2, sleeper 250 kg/m,
# support 1e8 + 8e4 i omega N/m2.
frequency_hz,real_m_n,imag_m_n
"""


def moving_load(shear_speed, poisson_ratio, density, offset, speed):
    """Return u_z/F beside a load on a half-space, slower than its Rayleigh wave, m/N.

    With q = (v/c_s)², P = √(1 − v²/c_p²), S = √(1 − q): u_z = F/(2πμy) · (−qP)/[(2 − q)² − 4PS], and
    (1 − ν)F/(2πμy) at rest.
    """
    scale = 1.0 / (2.0 * math.pi * density * shear_speed**2 * offset)
    if speed == 0.0:
        return (1.0 - poisson_ratio) * scale
    q = (speed / shear_speed) ** 2
    p_root = math.sqrt(1.0 - q * (1.0 - 2.0 * poisson_ratio) / (2.0 - 2.0 * poisson_ratio))
    s_root = math.sqrt(1.0 - q)
    return -q * p_root / ((2.0 - q) ** 2 - 4.0 * p_root * s_root) * scale


def winkler_rail(frequency):
    """Return the receptance of the rail on two layers of springs, m/N.

    With s = s_p (s_b − m_s ω²)/(s_p + s_b − m_s ω²) and κ⁴ = (s − m_R ω²)/EI: σ(0) = 1/(2√2 EI κ³).
    """
    bending_stiffness, rail_mass, sleeper_mass = 6.3777e6, 60.2, 250.0
    omega = 2.0 * math.pi * frequency
    pad, bed = 3e8 + 3e4j * omega, 1e8 + 8e4j * omega - sleeper_mass * omega**2
    kappa = ((pad * bed / (pad + bed) - rail_mass * omega**2) / bending_stiffness) ** 0.25
    return 1.0 / (2.0 * math.sqrt(2.0) * bending_stiffness * kappa**3)


def moving_load_file():
    """Return the text of moving_load.csv."""
    rows = [
        f"310.09,0.3,2000,5,{speed},{moving_load(310.09, 0.3, 2000.0, 5.0, speed):.5e}\n"
        for speed in (0, 100, 200, 250)
    ]
    return MOVING_LOAD_HEADER + "".join(rows)


def winkler_rail_file():
    """Return the text of winkler_rail.csv."""
    receptances = ((frequency, winkler_rail(frequency)) for frequency in (20, 50, 100))
    rows = [f"{frequency},{value.real:.6e},{value.imag:.6e}\n" for frequency, value in receptances]
    return WINKLER_RAIL_HEADER + "".join(rows)


if __name__ == "__main__":
    (DATA / "moving_load.csv").write_text(moving_load_file(), encoding="utf-8")
    (DATA / "winkler_rail.csv").write_text(winkler_rail_file(), encoding="utf-8")
