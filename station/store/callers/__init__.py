"""Who may call the station: keys, logins of browsers; and what they were answered."""

from station.store.callers.kept_answers import Call, Standing, begin_call, forget_call, keep_answer
from station.store.callers.keyring import add_key, issue_key, keys_of, revoke_key, rotate_key
from station.store.callers.keys import (
    Caller,
    Scope,
    any_key,
    caller_of,
    digest,
    ensure_unguessable,
    note_use,
    usable,
    used_lately,
)
from station.store.callers.logins import (
    OpenLogin,
    add_login,
    caller_logged_in,
    end_login,
    end_login_named,
    login_name,
    open_logins,
)

__all__ = [
    "Call",
    "Caller",
    "OpenLogin",
    "Scope",
    "Standing",
    "add_key",
    "add_login",
    "any_key",
    "begin_call",
    "caller_logged_in",
    "caller_of",
    "digest",
    "end_login",
    "end_login_named",
    "ensure_unguessable",
    "forget_call",
    "issue_key",
    "keep_answer",
    "keys_of",
    "login_name",
    "note_use",
    "open_logins",
    "revoke_key",
    "rotate_key",
    "usable",
    "used_lately",
]
