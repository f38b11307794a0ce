"""Where the capture processes listen."""

from pathlib import Path


def socket_path(run_dir: Path, sensor: str) -> Path:
    """Return where a sensor's capture process listens for commands."""
    return run_dir / f"{sensor}.sock"
