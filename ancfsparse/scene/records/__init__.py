"""Plain data of a definition: records, signals, functions of time."""
