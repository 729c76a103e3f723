"""Pictures and tables from plain results; the only room that knows matplotlib and rich."""
