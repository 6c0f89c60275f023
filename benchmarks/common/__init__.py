"""What the studies share: models, references, the timed contest, tables, charts, pages."""
