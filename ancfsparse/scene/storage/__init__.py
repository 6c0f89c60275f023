"""Files, copies, digest, printing of a scene."""
