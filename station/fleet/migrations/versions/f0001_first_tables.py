"""The first tables: what stations tell of passes, wheels, calibrations and nights."""

import sqlalchemy as sa
from alembic import op

revision = "f0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the tables, those that others refer to first."""
    _create_stations()
    _create_passes()
    _create_wheels()
    _create_axles()
    _create_alarms()
    _create_calibrations()
    _create_recalibrations()
    _create_refusals()


def _create_stations() -> None:
    op.create_table(
        "fleet_stations",
        sa.Column("id", sa.String, nullable=False),
        sa.Column("name", sa.String, nullable=False),
        sa.Column("software", sa.String, nullable=False),
        sa.Column("first_heard_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("last_heard_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("clock_ahead_s", sa.Double(), nullable=False),
        sa.Column("unsent", sa.Integer, nullable=False),
        sa.Column("unsent_since", sa.DateTime(timezone=True), nullable=True),
        sa.PrimaryKeyConstraint("id", name="pk_fleet_stations"),
    )
    op.create_table(
        "fleet_epochs",
        sa.Column("station", sa.String, nullable=False),
        sa.Column("epoch", sa.Integer, nullable=False),
        sa.Column("store_epoch", sa.String, nullable=False),
        sa.Column("began_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("heard_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("number", sa.BigInteger, nullable=False),
        sa.Column("token", sa.String, nullable=True),
        sa.ForeignKeyConstraint(["station"], ["fleet_stations.id"], name="fk_fleet_epochs_station"),
        sa.PrimaryKeyConstraint("station", "epoch", name="pk_fleet_epochs"),
        sa.UniqueConstraint("station", "store_epoch", name="uq_fleet_epochs_station_store_epoch"),
    )


def _create_passes() -> None:
    op.create_table(
        "fleet_passes",
        sa.Column("station", sa.String, nullable=False),
        sa.Column("epoch", sa.Integer, nullable=False),
        sa.Column("id", sa.String, nullable=False),
        sa.Column("opened_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("finished_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("state", sa.String, nullable=False),
        sa.Column("train", sa.String, nullable=True),
        sa.Column("axles", sa.Integer, nullable=True),
        sa.Column("reason", sa.Text, nullable=True),
        sa.Column("superseded", sa.Boolean, nullable=False),
        sa.ForeignKeyConstraint(
            ["station", "epoch"],
            ["fleet_epochs.station", "fleet_epochs.epoch"],
            name="fk_fleet_passes_station_epoch",
        ),
        sa.PrimaryKeyConstraint("station", "epoch", "id", name="pk_fleet_passes"),
    )
    op.create_index(
        "ix_fleet_passes_station_opened_at", "fleet_passes", ["station", "opened_at"], unique=False
    )


def _create_wheels() -> None:
    op.create_table(
        "fleet_wheels",
        sa.Column("station", sa.String, nullable=False),
        sa.Column("epoch", sa.Integer, nullable=False),
        sa.Column("id", sa.Integer, autoincrement=False, nullable=False),
        sa.Column("pass_id", sa.String, nullable=False),
        sa.Column("recording_id", sa.String, nullable=False),
        sa.Column("frame", sa.Integer, nullable=False),
        sa.Column("sensor", sa.String, nullable=False),
        sa.Column("calibration_id", sa.String, nullable=False),
        sa.Column("rig_calibration_id", sa.String, nullable=True),
        sa.Column("reference", sa.String, nullable=False),
        sa.Column("regime", sa.String, nullable=True),
        sa.Column("software", sa.String, nullable=False),
        sa.Column("measured_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("readings", sa.JSON, nullable=False),
        sa.Column("reason", sa.Text, nullable=True),
        sa.Column("profile", sa.JSON, nullable=True),
        sa.ForeignKeyConstraint(
            ["station", "epoch", "pass_id"],
            ["fleet_passes.station", "fleet_passes.epoch", "fleet_passes.id"],
            name="fk_fleet_wheels_station_epoch_pass_id",
        ),
        sa.PrimaryKeyConstraint("station", "epoch", "id", name="pk_fleet_wheels"),
    )
    op.create_index(
        "ix_fleet_wheels_station_epoch_pass_id",
        "fleet_wheels",
        ["station", "epoch", "pass_id"],
        unique=False,
    )


def _create_axles() -> None:
    op.create_table(
        "fleet_axles",
        sa.Column("station", sa.String, nullable=False),
        sa.Column("epoch", sa.Integer, nullable=False),
        sa.Column("pass_id", sa.String, nullable=False),
        sa.Column("place", sa.Integer, autoincrement=False, nullable=False),
        sa.Column("side", sa.String, nullable=False),
        sa.Column("number", sa.Integer, nullable=True),
        sa.Column("placing", sa.String, nullable=False),
        sa.Column("passed_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("wheel_id", sa.Integer, nullable=True),
        sa.Column("wheelset", sa.String, nullable=True),
        sa.Column("wheelset_side", sa.String, nullable=True),
        sa.Column("vehicle", sa.String, nullable=True),
        sa.Column("position", sa.String, nullable=True),
        sa.Column("jumps", sa.JSON, nullable=False),
        sa.Column("back_to_back", sa.JSON, nullable=True),
        sa.Column("reason", sa.Text, nullable=True),
        sa.Column("remark", sa.Text, nullable=True),
        sa.ForeignKeyConstraint(
            ["station", "epoch", "pass_id"],
            ["fleet_passes.station", "fleet_passes.epoch", "fleet_passes.id"],
            name="fk_fleet_axles_station_epoch_pass_id",
        ),
        sa.PrimaryKeyConstraint(
            "station", "epoch", "pass_id", "place", "side", name="pk_fleet_axles"
        ),
    )
    op.create_index("ix_fleet_axles_wheelset", "fleet_axles", ["wheelset"], unique=False)


def _create_alarms() -> None:
    op.create_table(
        "fleet_alarms",
        sa.Column("station", sa.String, nullable=False),
        sa.Column("epoch", sa.Integer, nullable=False),
        sa.Column("wheel_id", sa.Integer, autoincrement=False, nullable=False),
        sa.Column("quantity", sa.String, nullable=False),
        sa.Column("pass_id", sa.String, nullable=False),
        sa.Column("at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("alarm", sa.String, nullable=False),
        sa.Column("value", sa.Double(), nullable=False),
        sa.Column("u95", sa.Double(), nullable=False),
        sa.Column("wheelset", sa.String, nullable=True),
        sa.Column("wheelset_side", sa.String, nullable=True),
        sa.ForeignKeyConstraint(
            ["station", "epoch", "pass_id"],
            ["fleet_passes.station", "fleet_passes.epoch", "fleet_passes.id"],
            name="fk_fleet_alarms_station_epoch_pass_id",
        ),
        sa.PrimaryKeyConstraint("station", "epoch", "wheel_id", "quantity", name="pk_fleet_alarms"),
    )
    op.create_index("ix_fleet_alarms_at", "fleet_alarms", ["at"], unique=False)
    op.create_index(
        "ix_fleet_alarms_station_epoch_pass_id",
        "fleet_alarms",
        ["station", "epoch", "pass_id"],
        unique=False,
    )


def _create_calibrations() -> None:
    op.create_table(
        "fleet_calibrations",
        sa.Column("station", sa.String, nullable=False),
        sa.Column("epoch", sa.Integer, nullable=False),
        sa.Column("of", sa.String, nullable=False),
        sa.Column("name", sa.String, nullable=False),
        sa.Column("version", sa.Integer, autoincrement=False, nullable=False),
        sa.Column("calibration_id", sa.String, nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("activated_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("activated_by", sa.String, nullable=False),
        sa.Column("method", sa.String, nullable=True),
        sa.Column("passed", sa.Boolean, nullable=True),
        sa.Column("rms_dots_px", sa.Double(), nullable=True),
        sa.Column("rms_stripe_px", sa.Double(), nullable=True),
        sa.Column("superseded", sa.Boolean, nullable=False),
        sa.ForeignKeyConstraint(
            ["station", "epoch"],
            ["fleet_epochs.station", "fleet_epochs.epoch"],
            name="fk_fleet_calibrations_station_epoch",
        ),
        sa.PrimaryKeyConstraint(
            "station", "epoch", "of", "name", "version", name="pk_fleet_calibrations"
        ),
    )


def _create_recalibrations() -> None:
    op.create_table(
        "fleet_recalibrations",
        sa.Column("station", sa.String, nullable=False),
        sa.Column("epoch", sa.Integer, nullable=False),
        sa.Column("id", sa.String, nullable=False),
        sa.Column("sensor", sa.String, nullable=False),
        sa.Column("state", sa.String, nullable=False),
        sa.Column("ordered_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("ended_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("outcome", sa.String, nullable=True),
        sa.Column("action", sa.String, nullable=True),
        sa.Column("alarm", sa.Boolean, nullable=True),
        sa.Column("present_version", sa.Integer, nullable=True),
        sa.Column("figures", sa.JSON, nullable=True),
        sa.Column("reasons", sa.JSON, nullable=True),
        sa.Column("reason", sa.Text, nullable=True),
        sa.Column("superseded", sa.Boolean, nullable=False),
        sa.ForeignKeyConstraint(
            ["station", "epoch"],
            ["fleet_epochs.station", "fleet_epochs.epoch"],
            name="fk_fleet_recalibrations_station_epoch",
        ),
        sa.PrimaryKeyConstraint("station", "epoch", "id", name="pk_fleet_recalibrations"),
    )
    op.create_index(
        "ix_fleet_recalibrations_station_sensor",
        "fleet_recalibrations",
        ["station", "sensor", "ordered_at"],
        unique=False,
    )


def _create_refusals() -> None:
    op.create_table(
        "fleet_refusals",
        sa.Column("station", sa.String, nullable=False),
        sa.Column("epoch", sa.Integer, nullable=False),
        sa.Column("kind", sa.String, nullable=False),
        sa.Column("key", sa.String, nullable=False),
        sa.Column("number", sa.BigInteger, nullable=False),
        sa.Column("why", sa.Text, nullable=False),
        sa.Column("refused_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["station", "epoch"],
            ["fleet_epochs.station", "fleet_epochs.epoch"],
            name="fk_fleet_refusals_station_epoch",
        ),
        sa.PrimaryKeyConstraint("station", "epoch", "kind", "key", name="pk_fleet_refusals"),
    )


def downgrade() -> None:
    """Drop them, those that refer to others first."""
    for table in (
        "fleet_wheels",
        "fleet_axles",
        "fleet_alarms",
        "fleet_refusals",
        "fleet_recalibrations",
        "fleet_passes",
        "fleet_calibrations",
        "fleet_epochs",
        "fleet_stations",
    ):
        op.drop_table(table)
