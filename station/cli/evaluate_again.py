"""`station evaluate repeatability` and `leave-one-out`: calibrating again with fewer pictures."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from calib import LeftOutPose, Method, Repeatability, Target
from station.cli.options import Sources, TargetText
from station.cli.output import AsJson, emit, progress_bar
from station.cli.verdict import Limit, hold_against, rounded
from station.documents import CameraDocument
from station.errors import NothingMeasurable
from station.pipeline import Solving, leaving_out_of_sources, repeatability_of_sources

CameraPath = Annotated[
    Path | None, typer.Option(metavar="FILE", help="camera.json; solved with the rest without.")
]


def repeatability(
    sources: Sources,
    target: TargetText,
    camera: CameraPath = None,
    method: Annotated[
        list[Method] | None, typer.Option(help="How the light plane is solved; every way.")
    ] = None,
    draws: Annotated[int, typer.Option(min=2, help="How many times pictures are drawn.")] = 20,
    take: Annotated[int, typer.Option(min=2, help="How many pictures at a time.")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="Of the draws.")] = 0,
    limit: Limit = None,
    as_json: AsJson = False,
) -> None:
    """Calibrate from parts of the pictures, drawn at random, and tell the scatter."""
    with progress_bar("repeatability") as progress:
        answers = repeatability_of_sources(
            sources,
            _solving(target, camera),
            methods=method or tuple(Method),
            draws=draws,
            take=take,
            seed=seed,
            progress=progress,
        )
    data = {
        "draws": draws,
        "take": take,
        "seed": seed,
        "methods": {answer.method.value: _repeatability_data(answer) for answer in answers},
        "limit_mm": limit,
    }
    emit(data, "\n".join(map(_repeatability_text, answers)), as_json=as_json)
    for answer in answers:
        hold_against(limit, answer.sheet_spread_mm, f"spread of the sheet by {answer.method}")


def leave_one_out(
    sources: Sources,
    target: TargetText,
    camera: CameraPath = None,
    method: Annotated[Method, typer.Option(help="How the light plane is solved.")] = Method.JOINT,
    limit: Limit = None,
    as_json: AsJson = False,
) -> None:
    """Measure the stripe of each picture by a calibration from the others."""
    with progress_bar("leave-one-out") as progress:
        poses, unseen = leaving_out_of_sources(
            sources, _solving(target, camera), method=method, progress=progress
        )
    measured = [pose for pose in poses if not pose.reason]
    left_out = {**dict(unseen), **{pose.name: pose.reason for pose in poses if pose.reason}}
    if not measured:
        first = next(iter(left_out.items()), ("no picture", "nothing in the sources"))
        raise NothingMeasurable(f"no pose could be left out; {first[0]}: {first[1]}")
    rms = float(np.sqrt(np.mean([pose.rms_mm**2 for pose in measured])))
    data = {
        "method": method.value,
        "rms_mm": rms,
        "poses": [_pose_data(pose) for pose in measured],
        "left_out": left_out,
        "limit_mm": limit,
    }
    lines = [
        f"{pose.name}: RMS {pose.rms_mm:.4f} mm, mean {pose.mean_mm:+.4f} mm"
        for pose in sorted(measured, key=lambda pose: -pose.rms_mm)
    ]
    lines += [f"left out {name}: {reason}" for name, reason in left_out.items()]
    lines.append(f"RMS over {len(measured)} poses {rms:.4f} mm ({method})")
    emit(data, "\n".join(lines), as_json=as_json)
    hold_against(limit, rms, "RMS of the left-out poses")


def _solving(target: str, camera: Path | None) -> Solving:
    return Solving(Target.parse(target), CameraDocument.read(camera).model() if camera else None)


def _repeatability_data(answer: Repeatability) -> dict[str, Any]:
    return {
        "mean": dict(zip("abcd", answer.mean.tolist(), strict=True)),
        "spread": dict(zip("abcd", answer.spread.tolist(), strict=True)),
        "coefficients": answer.coefficients.tolist(),
        "sheet_spread_mm": answer.sheet_spread_mm,
        "expected_spread_mm": answer.expected_spread_mm,
        "refusals": list(answer.refusals),
    }


def _repeatability_text(answer: Repeatability) -> str:
    spread = ", ".join(
        f"{name} {value:.2e}" for name, value in zip("abcd", answer.spread, strict=True)
    )
    refused = f"; {len(answer.refusals)} refused" if answer.refusals else ""
    return (
        f"{answer.method}: sheet {answer.sheet_spread_mm:.4f} mm (its covariance expects "
        f"{answer.expected_spread_mm:.4f}); {spread} (d in mm); {len(answer.coefficients)} "
        f"draws{refused}"
    )


def _pose_data(pose: LeftOutPose) -> dict[str, Any]:
    return {
        "name": pose.name,
        "rms_mm": pose.rms_mm,
        "mean_mm": pose.mean_mm,
        "errors_mm": rounded(pose.errors_mm),
    }
