"""What nights remember: a folder of run folders beside a pool of answers, and what is made of them."""
