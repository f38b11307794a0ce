"""`station intrinsics`: from pictures of a target to camera.json."""

from pathlib import Path
from typing import Annotated

import typer

from calib import Target
from station.cli.options import Sources, TargetText
from station.cli.output import AsJson, emit, progress_bar
from station.documents import CameraDocument
from station.pipeline import calibrate_camera_from_sources


def intrinsics(
    sources: Sources,
    target: TargetText,
    out: Annotated[Path, typer.Option(metavar="FILE", help="camera.json to write.")],
    as_json: AsJson = False,
) -> None:
    """Solve the camera model from pictures of a target (Zhang's method, then least squares)."""
    with progress_bar("intrinsics") as progress:
        camera = calibrate_camera_from_sources(sources, Target.parse(target), progress=progress)
    document = CameraDocument.from_model(camera)
    document.write(out)
    text = (
        f"fx {camera.fx:.3f} fy {camera.fy:.3f} cx {camera.cx:.3f} cy {camera.cy:.3f} px, "
        f"k1 {camera.k1:+.5f} k2 {camera.k2:+.5f}, written to {out}"
    )
    emit(document.model_dump(mode="json"), text, as_json=as_json)
