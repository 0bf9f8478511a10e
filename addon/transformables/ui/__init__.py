# SPDX-License-Identifier: GPL-3.0-or-later
"""What all stages share: the running job, its overlay, preferences, and the panel that the stages sit in."""


def register_settings(package):
    from . import preferences

    preferences.register(package)


def unregister_settings():
    from . import preferences

    preferences.unregister()


def register_jobs():
    from . import block_overlay, handlers, overlays, seam_overlay

    overlays.register()
    block_overlay.register()
    seam_overlay.register()
    handlers.register()


def unregister_jobs():
    """Ends a running job first: whatever follows may take away what it needs."""
    from . import block_overlay, handlers, overlays, seam_overlay, session, thumbnail

    session.end()
    session.forget()
    handlers.unregister()
    seam_overlay.unregister()
    block_overlay.unregister()
    overlays.unregister()
    thumbnail.unregister()
