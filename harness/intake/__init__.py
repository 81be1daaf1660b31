"""What comes from outside as files and texts, read as a stranger's: limits, documents, typed fields, harmless text."""
