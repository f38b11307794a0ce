"""The settings of files and space."""

from pydantic import Field

from station.settings.section import Section


class StorageSettings(Section):
    """The disk: how long files grow, what is kept free, and what makes way."""

    rotate_s: float | None = Field(default=60.0, gt=0.0)
    """A pass's recording goes on in a next file after so many seconds."""
    rotate_mb: float | None = Field(default=None, gt=0.0)
    """Any recording goes on in a next file after so many megabytes (10^6 bytes)."""
    longest_pass_s: float = Field(default=60.0, gt=0.0)
    """The longest pass of a sensor that runs free, s: space for it is there before it is armed."""
    most_axles: int = Field(default=1000, ge=1)
    """Axles of the longest train, one triggered frame each: 250 wagons of four axles."""
    most_poses: int = Field(default=200, ge=1)
    """Pictures of a calibration session at most, as far as space is kept for them."""
    reserve_mb: float = Field(default=100.0, ge=0.0)
    """Space that no frame takes, MB: the station's store must go on being written."""
    keep_free_gb: float = Field(default=1.0, ge=0.0)
    """Free space that no pass or session may use up, GB (10^9 bytes)."""
    quota_gb: float | None = Field(default=None, gt=0.0)
    """All recordings together, GB: beyond, measured ones make way, oldest first; absent: no limit.

    With `quota_gb` or `keep_days` measured ones make way for `keep_free_gb` too; without either
    none of them is ever deleted.
    """
    keep_days: float | None = Field(default=None, gt=0.0)
    """Measured recordings older than so many days are deleted; absent: they stay."""
    keep_failed_days: float | None = Field(default=None, gt=0.0)
    """Recordings of passes that failed are deleted after so many days: give somebody the time to
    look at them; absent: they stay."""
    keep_uploads_days: float | None = Field(default=None, gt=0.0)
    """Uploaded recordings are deleted so many days after they came, unless a calibration in force
    was made from them; absent: they stay until somebody deletes them."""
    compact_after_days: float | None = Field(default=None, ge=0.0)
    """Measured recordings are made smaller, without loss, after so many days; absent: never.  That
    is done while no train passes."""
