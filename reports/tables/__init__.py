"""What pages say in rows and sentences, worked out of a store."""
