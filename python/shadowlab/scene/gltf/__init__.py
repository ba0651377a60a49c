"""The reader of glTF 2.0 (Khronos Group 2021, "glTF 2.0 Specification"), one file per part of the format."""
