"""What is looked at: scenes, the library of procedural ones, and views of them."""
