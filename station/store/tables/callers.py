"""Who may call the station, what was answered, and what they changed."""

from datetime import datetime

from sqlalchemy import ForeignKey, Index
from sqlalchemy.orm import Mapped, mapped_column

from station.store.tables.base import JsonObject, Table


class Key(Table):
    """A bearer key: its name and what it may do; the key itself only as a hash."""

    __tablename__ = "keys"

    id: Mapped[str] = mapped_column(primary_key=True)
    name: Mapped[str]
    scopes: Mapped[JsonObject]  # {"scopes": [...]}
    secret_sha256: Mapped[str]
    created_at: Mapped[datetime]
    expires_at: Mapped[datetime | None]
    revoked_at: Mapped[datetime | None]
    last_used_at: Mapped[datetime | None]  # to within some minutes


class Login(Table):
    """That a browser was let in by a key: its cookie only as a hash."""

    __tablename__ = "logins"

    sha256: Mapped[str] = mapped_column(primary_key=True)
    key_id: Mapped[str | None] = mapped_column(ForeignKey("keys.id"), index=True)
    environment_sha256: Mapped[str | None]  # of the key of the environment, where it was that
    created_at: Mapped[datetime]
    expires_at: Mapped[datetime] = mapped_column(index=True)


class KeptAnswer(Table):
    """The answer to a call that carried an Idempotency-Key, for when the call comes again."""

    __tablename__ = "kept_answers"

    caller: Mapped[str] = mapped_column(primary_key=True)
    key: Mapped[str] = mapped_column(primary_key=True)
    fingerprint: Mapped[str]  # of method, address and body
    asked_at: Mapped[datetime] = mapped_column(index=True)
    status: Mapped[int | None]  # absent while the call is being answered
    headers: Mapped[JsonObject | None]
    body: Mapped[bytes | None]


class AuditEntry(Table):
    """What somebody changed; rows are added and never touched again, which triggers see to."""

    __tablename__ = "audit_entries"
    __table_args__ = (Index("ix_audit_entries_subject_id", "subject", "id"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    at: Mapped[datetime]
    who: Mapped[str]
    address: Mapped[str | None]  # of the caller, where it came over the network
    action: Mapped[str]
    kind: Mapped[str]  # of thing that was changed
    subject: Mapped[str]  # its name
    before: Mapped[JsonObject | None]
    after: Mapped[JsonObject | None]
