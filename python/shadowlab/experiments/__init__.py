"""Many maps in many views: one evaluator, one vocabulary of columns, and the questions that are asked of them."""
