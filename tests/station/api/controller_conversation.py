"""Makes a controller's calls in every way they may come, and judges each answer by what was
foreseen: plainly, twice at a time, cut off, unread, and while the API process dies."""

from controller_calls import (
    Asked,
    send,
    send_and_go,
    send_half,
    send_to_the_dying,
    send_twice,
    settle,
)
from controller_reading import read_all

REFUSED_AT_ONCE, FAILED = 300, 500


def post(path, body, key):
    return Asked("POST", path, body, {} if key is None else {"Idempotency-Key": key})


class Conversation:
    """What was asked of the station, and what it answered; `foresee` says of a call, and tells the
    model, what its answer is to be."""

    def __init__(self, served, model):
        self.served, self.model = served, model
        self.client = served.client()
        self.kept = {}
        """Calls and answers by Idempotency-Key."""

    def close(self):
        self.client.close()

    def ask(self, asked, how, deeds, foresee):
        {
            "plain": self.ask_plainly,
            "twice": self.ask_twice,
            "half": self.ask_half,
            "unread": self.ask_unread,
            "dying": lambda *call: self.ask_the_dying(*call, deeds),
        }[how](asked, foresee)
        read_all(self.served, self.model, foreseen=how != "dying")

    def ask_plainly(self, asked, foresee):
        expected = self.foreseen(asked, foresee)
        self.judge(asked, send(self.client, asked), {expected})

    def ask_twice(self, asked, foresee):
        first = self.foreseen(asked, foresee)
        self.note_kept(asked, first)
        second = self.foreseen(asked, foresee)
        answers = send_twice(self.served, asked)
        # The second may find the first at it: a pass that arms, a key that is being answered.
        early = {409} if asked.keyed or first >= REFUSED_AT_ONCE else set()
        early |= {200} if asked.method == "PUT" else set()
        assert len(answers) == 2, (asked, answers)
        got = [answer.status_code for answer in answers]
        assert first in got, (asked, got, first)
        got.remove(first)
        assert got[0] in {second} | early, (asked, got, second)
        for answer in answers:
            self.judge(asked, answer, {first, second} | early)

    def ask_half(self, asked, _foresee):
        send_half(self.served, asked)
        settle(self.served)

    def ask_unread(self, asked, foresee):
        if asked.method == "POST" and not asked.keyed:
            asked = post(asked.path, asked.body, f"unread-{len(self.kept)}")
        first = self.foreseen(asked, foresee)
        send_and_go(self.served, asked)
        settle(self.served)
        self.note_kept(asked, first)
        second = self.foreseen(asked, foresee)
        # The station may have found the caller gone before it had read what it asked.
        self.judge(asked, send(self.client, asked), {first, second})

    def ask_the_dying(self, asked, foresee, deeds):
        first = self.foreseen(asked, foresee)
        self.served.life.end_after(deeds)
        send_to_the_dying(self.served, asked)
        self.begin_again(None)
        if asked.method != "POST" or asked.keyed:
            # As if it were the first, where it finds what it did; or as things are now.
            expected = {first, self.foreseen(asked, foresee)}
            self.judge(asked, send(self.client, asked), expected)

    def begin_again(self, deeds):
        self.client.close()
        self.served.kill_and_begin_again(deeds)
        self.client = self.served.client()
        read_all(self.served, self.model, foreseen=False)
        begun = [*self.model.passes.values(), *self.model.sessions.values()]
        assert "armed" not in {known.state for known in begun}, ("a start left half done", begun)

    def foreseen(self, asked, foresee):
        known = self.kept.get(asked.headers.get("Idempotency-Key"))
        if known is None or known == (asked, None, None):
            return foresee()
        return known[1] if known[0] == asked else 422

    def note_kept(self, asked, status):
        if asked.keyed and status < REFUSED_AT_ONCE:
            self.kept.setdefault(asked.headers["Idempotency-Key"], (asked, status, None))

    def judge(self, asked, answer, expected):
        told = (asked, answer.status_code, answer.text, expected)
        assert answer.status_code in expected, told
        key = asked.headers.get("Idempotency-Key")
        if answer.status_code >= REFUSED_AT_ONCE:
            assert answer.json()["detail"], told
            self.note_refused(asked, key, failed=answer.status_code >= FAILED)
        elif key is not None:
            _, status, before = self.kept.get(key, (asked, None, None))
            assert before in {None, answer.text}, (asked, before, answer.text)
            self.kept[key] = (asked, status or answer.status_code, answer.text)

    def note_refused(self, asked, key, *, failed):
        """A refusal frees the key; a failure may have done something, and keeps it."""
        if key is not None and failed:
            self.kept.setdefault(key, (asked, None, None))
        elif self.kept.get(key) == (asked, None, None):
            del self.kept[key]
