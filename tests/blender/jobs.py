# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel's jobs came to, and what they told their worker."""


def last():
    """The panel's last job, which must have ended."""
    from transformables.ui import session
    assert session.current() is None, "the job was not ended"
    return session.last


def told_to_worker(run):
    """The message that an operator sends to its worker."""
    from transformables.core import job
    sent, real = [], job.Job.__init__

    def init(self, message, arrays, *rest, **more):
        sent.append(message)
        real(self, message, arrays, *rest, **more)

    job.Job.__init__ = init
    try:
        assert run() == {"FINISHED"}
    finally:
        job.Job.__init__ = real
    return sent[0]
