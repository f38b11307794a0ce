"""The table of the people who have logged in with a browser."""

from datetime import datetime

from sqlalchemy import ForeignKey
from sqlalchemy.orm import Mapped, mapped_column

from station.store.tables import Table


class Login(Table):
    """That a browser was let in by a key: its cookie only as a hash."""

    __tablename__ = "logins"

    sha256: Mapped[str] = mapped_column(primary_key=True)
    key_id: Mapped[str | None] = mapped_column(ForeignKey("keys.id"), index=True)
    environment_sha256: Mapped[str | None]  # of the key of the environment, where it was that
    created_at: Mapped[datetime]
    expires_at: Mapped[datetime] = mapped_column(index=True)
