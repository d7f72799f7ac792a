"""One run: processes started, watched and ended; its bag judged."""
