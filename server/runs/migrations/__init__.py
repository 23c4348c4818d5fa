"""The journal's migrations, applied by `journal.Journal` when it opens."""
