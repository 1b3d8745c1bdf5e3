"""Limits of processor time: one of rsc, a longer one of the judge, whose second engine is written in Python."""

import signal

LIMIT, JUDGE = 60.0, 240.0  # s


class TooLong(KeyboardInterrupt):
    """rsc took longer than LIMIT: to it a Ctrl-C, which stops runs in its threads."""


class JudgeTooLong(Exception):
    """The judge took longer than JUDGE."""


def begin():
    """From here on the time of rsc counts."""
    _count(TooLong, LIMIT)


def judging():
    """rsc has answered, and from here on the time of the judge counts; TooLong where rsc took its Ctrl-C and told what it had."""
    if end():
        raise TooLong
    _count(JudgeTooLong, JUDGE)


def end():
    """Nothing counts any more; returns whether the last limit had been passed."""
    return signal.setitimer(signal.ITIMER_PROF, 0.0)[0] == 0.0


def _count(error, seconds):
    def alarm(number, frame):
        raise error

    signal.signal(signal.SIGPROF, alarm)
    signal.setitimer(signal.ITIMER_PROF, seconds)
