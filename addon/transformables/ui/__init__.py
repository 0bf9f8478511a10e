# SPDX-License-Identifier: GPL-3.0-or-later
"""What all stages share: the running job, its overlay, preferences, and the panel that the stages sit in."""


def register_settings(package):
    from . import preferences

    preferences.register(package)


def unregister_settings():
    from . import preferences

    preferences.unregister()


def register_jobs():
    from . import handlers, overlays

    overlays.register()
    handlers.register()


def unregister_jobs():
    """Ends a running job first: whatever follows may take away what it needs."""
    from . import handlers, overlays, session, thumbnail

    session.end()
    session.forget()
    handlers.unregister()
    overlays.unregister()
    thumbnail.unregister()
