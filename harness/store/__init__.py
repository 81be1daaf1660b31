"""What is on disk: records, the journal, sealed files, and the tables made from them."""
