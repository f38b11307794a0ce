"""Measured profiles over their reference: as SVG, and what other drawings of them are made of."""

from station.plots.drawing import profile_svg, write_plots
from station.plots.gauges import Gauge, gauges_of
from station.plots.panel import Place
from station.plots.profile_panel import D_MM, H_MM, outline_mm
from station.plots.shape import Drawn
from station.plots.wear_panel import shared_u95, tread_wear

__all__ = [
    "D_MM",
    "Drawn",
    "Gauge",
    "H_MM",
    "Place",
    "gauges_of",
    "outline_mm",
    "profile_svg",
    "shared_u95",
    "tread_wear",
    "write_plots",
]
