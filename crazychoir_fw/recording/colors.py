"""Colors of drones, the same in plots and films."""

import numpy as np

FEW = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#6A3D9A", "#444444")
"""Colors that people with any color vision tell apart (Okabe and Ito, yellow replaced for white paper)."""


def palette(drones: int) -> list[str]:
    """Return one color per drone: distinct ones for a few, a scale that is even in brightness for many."""
    if drones <= len(FEW):
        return list(FEW[:drones])
    scale = [(0, "#00204C"), (0.25, "#31446B"), (0.45, "#0072B2"), (0.65, "#2A9D8F"), (0.82, "#E69F00"), (1, "#C8401A")]
    stops = np.array([at for at, _ in scale])
    values = np.array([[int(color[k : k + 2], 16) for k in (1, 3, 5)] for _, color in scale])
    places = np.linspace(0.0, 1.0, drones)
    mixed = np.column_stack([np.interp(places, stops, values[:, k]) for k in range(3)])
    return ["#{:02x}{:02x}{:02x}".format(*rgb) for rgb in mixed.round().astype(int)]


def rgb(color: str) -> tuple[float, float, float]:
    """Return red, green and blue in [0, 1] of a color such as `#0072B2`."""
    red, green, blue = (int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue
