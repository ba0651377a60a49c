"""Other programs behind plain numpy arrays, for tests and benches: OpenGL through moderngl, pyrender, embreex."""
