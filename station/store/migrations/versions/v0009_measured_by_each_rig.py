"""A wheel measured again with another calibration of its rig is a measurement of its own."""

import sqlalchemy as sa
from alembic import context, op

from station.errors import StationError

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None

_KEY = ["recording_id", "frame", "calibration_id"]
_CONSTRAINT = "uq_measurements_recording_id_frame_calibration_id"
_OF_SENSORS, _OF_RIGS = "uq_measurements_of_sensors", "uq_measurements_of_rigs"


def upgrade() -> None:
    """Tell the measurements of rigs apart by the rig's calibration as well."""
    with op.batch_alter_table("measurements") as table:
        table.drop_constraint(_CONSTRAINT, type_="unique")
    without, of_rigs = (sa.text(f"rig_calibration_id IS {null}") for null in ("NULL", "NOT NULL"))
    _create(_OF_SENSORS, _KEY, without)
    _create(_OF_RIGS, [*_KEY, "rig_calibration_id"], of_rigs)


def downgrade() -> None:
    """Go back to one measurement a calibration of the sensor.

    Raises
    ------
    StationError
        If a wheel was measured with several calibrations of a rig, and the caller of `migrate` did
        not say that all but the last may be lost.
    """
    # Every word of these statements is this file's own, hence S608 below.
    again = (
        "SELECT id FROM measurements AS older WHERE EXISTS (SELECT 1 FROM measurements AS newer"
        " WHERE newer.recording_id = older.recording_id AND newer.frame = older.frame"
        " AND newer.calibration_id = older.calibration_id AND newer.id > older.id)"
    )
    if op.get_bind().scalar(sa.text(f"SELECT count(*) FROM ({again}) AS several")):  # noqa: S608
        if not context.config.attributes.get("losing"):
            raise StationError(
                "wheels were measured with several calibrations of their rig, which the store of "
                "an older version cannot hold; make a backup, then go back with losing=True"
            )
        for table in ("measurement_profiles", "axle_wheels"):
            op.execute(f"DELETE FROM {table} WHERE measurement_id IN ({again})")  # noqa: S608
        op.execute(f"DELETE FROM measurements WHERE id IN ({again})")  # noqa: S608
    op.drop_index(_OF_RIGS, "measurements")
    op.drop_index(_OF_SENSORS, "measurements")
    with op.batch_alter_table("measurements") as measurements:
        measurements.create_unique_constraint(_CONSTRAINT, _KEY)


def _create(name: str, columns: list[str], where: sa.TextClause) -> None:
    op.create_index(
        name, "measurements", columns, unique=True, sqlite_where=where, postgresql_where=where
    )
