"""Measured profiles over their reference, as SVG."""

from station.plots.drawing import profile_svg, write_plots

__all__ = ["profile_svg", "write_plots"]
