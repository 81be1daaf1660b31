"""What is seen of a case: thumbnails, strips, series, and what cameras saw."""
