"""What things are called: cases and engines of a store, outcomes, reasons, numbers and names as people read them."""
