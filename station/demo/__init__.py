"""The whole chain on simulated GigE cameras, and its answers beside the truth."""

from station.demo.judgement import (
    PlaneJudgement,
    RigJudgement,
    WheelJudgement,
    working_field_px,
)
from station.demo.report import as_data, as_text
from station.demo.run import DemoResult, FrameAccount, run_demo
from station.demo.scenario import Scenario

__all__ = [
    "DemoResult",
    "FrameAccount",
    "PlaneJudgement",
    "RigJudgement",
    "Scenario",
    "WheelJudgement",
    "as_data",
    "as_text",
    "run_demo",
    "working_field_px",
]
